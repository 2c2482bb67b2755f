"""A bar of text that follows work: redrawn on a terminal and in a notebook, a line for each tenth elsewhere."""

import builtins
import sys
import time

WIDTH = 24  # characters of the bar
REDRAWN_EVERY = 0.2  # s
ESTIMATED_AFTER = 2.0  # s


def is_notebook() -> bool:
    """Whether output goes to a cell of Jupyter, where a carriage return begins the line anew as on a terminal."""
    shell = getattr(builtins, "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"


def time_left(elapsed: float, done: float, missing: float) -> str:
    """What is left at the pace so far, "" where that says nothing yet."""
    if elapsed < ESTIMATED_AFTER or done <= 0.0 or missing <= 0.0:
        return ""
    minutes, seconds = divmod(round(elapsed * missing / done), 60)
    hours, minutes = divmod(minutes, 60)
    return f", {hours} h {minutes:02} min left" if hours else f", {minutes} min {seconds:02} s left" if minutes else \
        f", {seconds} s left"


class Bar:
    """`show` says how far the work is, `close` ends the line. `wanted`: None shows it on a terminal and in a notebook
    only."""

    def __init__(self, title: str, wanted: bool | None = None, stream=None):
        self.title = title
        self.stream = sys.stdout if stream is None else stream
        self.redraws = is_notebook() or self.stream.isatty()
        self.is_shown = self.redraws if wanted is None else bool(wanted)
        self.begin: tuple[float, float] | None = None  # when the work was first looked at, and how far it was
        self.drawn_at, self.tenth, self.width, self.written = -1.0, -1, 0, ""

    def show(self, fraction: float, text: str, is_last: bool = False) -> None:
        """`fraction`: of the work, 0 to 1; `text` follows the bar."""
        if not self.is_shown:
            return
        fraction = min(max(fraction, 0.0), 1.0)
        now, tenth = time.monotonic(), int(10.0 * fraction)
        n = int(WIDTH * fraction)
        self.begin = self.begin or (now, fraction)
        text += "" if is_last else time_left(now - self.begin[0], fraction - self.begin[1], 1.0 - fraction)
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
