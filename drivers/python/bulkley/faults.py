"""What can be wrong with the data of a run."""


class DataError(Exception):
    """A file that is missing, damaged or lacks something; the text is one sentence that names it."""
