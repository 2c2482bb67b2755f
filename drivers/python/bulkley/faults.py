"""What can be wrong: with the data of a run, or with a run itself."""

import os
import pathlib


class DataError(Exception):
    """A file that is missing, damaged or lacks something; the text is one sentence that names it."""


class RunError(Exception):
    """A run that cannot be made, was refused or has failed; the text is the program's sentence, or one about an argument.

    `code`: exit code of the program (2 refused, 3 failed; below 0: ended by that signal), None where it was not started;
    `folder`: output folder of the run, None where it has none.
    """

    def __init__(self, sentence: str, code: int | None = None, folder: str | os.PathLike | None = None):
        super().__init__(sentence)
        self.code = code
        self.folder = None if folder is None else pathlib.Path(folder)
