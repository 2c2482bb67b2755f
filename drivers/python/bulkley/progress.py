"""A bar of text that follows work: redrawn on a terminal and in a notebook, a line for each tenth elsewhere."""

import builtins
import sys
import time

WIDTH = 24  # characters of the bar
REDRAWN_EVERY = 0.2  # s


def is_notebook() -> bool:
    """Whether output goes to a cell of Jupyter, where a carriage return begins the line anew as on a terminal."""
    shell = getattr(builtins, "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"


class Bar:
    """`show` says how far the work is, `close` ends the line. `wanted`: None shows it on a terminal and in a notebook only."""

    def __init__(self, title: str, wanted: bool | None = None, stream=None):
        self.title = title
        self.stream = sys.stdout if stream is None else stream
        self.redraws = is_notebook() or self.stream.isatty()
        self.is_shown = self.redraws if wanted is None else bool(wanted)
        self.drawn_at, self.tenth, self.width, self.written = -1.0, -1, 0, ""

    def show(self, fraction: float, text: str, is_last: bool = False) -> None:
        """`fraction`: of the work, 0 to 1; `text` follows the bar."""
        if not self.is_shown:
            return
        fraction = min(max(fraction, 0.0), 1.0)
        now, tenth = time.monotonic(), int(10.0 * fraction)
        n = int(WIDTH * fraction)
        line = f"{self.title} [{'#' * n}{'-' * (WIDTH - n)}] {100.0 * fraction:3.0f} %  {text}"
        if self.redraws and (is_last or now >= self.drawn_at + REDRAWN_EVERY):
            self.stream.write("\r" + line.ljust(self.width))
            self.drawn_at, self.width = now, len(line)
        elif not self.redraws and (is_last and line != self.written or tenth > self.tenth):
            self.stream.write(line + "\n")
            self.written = line
        self.tenth = max(tenth, self.tenth)
        self.stream.flush()

    def close(self) -> None:
        """Ends the line that was drawn."""
        if self.is_shown and self.redraws and self.width:
            self.stream.write("\n")
            self.stream.flush()
