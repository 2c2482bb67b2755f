#!/usr/bin/env python3
"""`bulkley status` and `bulkley report` on runs that go on, have ended, were stopped, failed, were killed and are torn, and
on folders that hold no run. What they say is compared with status.json and history.csv; a run that is looked at ends with the
bits of one that is not."""

import base64
import csv
import html.parser
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import bulkley_program  # noqa: E402

LIMIT = 100.0  # s
SCENE = pathlib.Path(__file__).with_name("monitor.toml")
TITLE = "A <script>alert('ball')</script> & plate"
ENDLESS = ["--set", "time.end=1000", "--set", "output.frame_interval=0.5"]
EMPTY = {"meta", "img", "br", "link", "input", "hr"}  # elements of HTML without an end tag
# The smallest PNG: one pixel.
PIXEL = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==")


def expect(condition, sentence, outcome=None):
    if not condition:
        bulkley_program.fail(sentence, outcome)


def near(a, b, part=1e-5):
    return abs(a - b) <= part * max(abs(a), abs(b), 1e-30)


class Page(html.parser.HTMLParser):
    """Elements must close in the order in which they opened; keeps attributes, tags and text."""

    def __init__(self, text):
        super().__init__()
        self.open, self.faults, self.tags, self.links, self.text = [], [], [], [], ""
        self.feed(text)
        self.close()
        self.faults += [f"<{tag}> is not closed" for tag in self.open]

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [value for name, value in attributes if name in ("src", "href", "xlink:href", "data", "action")]
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> closes another element")

    def handle_data(self, data):
        self.text += data


class Monitor:
    def __init__(self, program, work):
        self.program, self.work = program, work

    def run(self, name, *arguments, ranks=1, code=0):
        outcome = self.program.run(["run", str(SCENE), "--out", name, "--quiet", *arguments], ranks, self.work, LIMIT)
        expect(outcome.code == code, f"{name}: exit code {outcome.code}, not {code}", outcome)
        return self.work / name

    def ask(self, *arguments, code=0):
        outcome = self.program.run(list(arguments), 1, self.work, LIMIT)
        expect(outcome.code == code, f"{' '.join(arguments)}: exit code {outcome.code}, not {code}", outcome)
        return outcome.text

    def status(self, folder):
        return json.loads(self.ask("status", str(folder), "--json"))

    def page(self, folder, *arguments):
        text = self.ask("report", str(folder), *arguments).strip()
        source = pathlib.Path(self.work / text).read_text(encoding="utf-8")
        page = Page(source)
        expect(not page.faults, f"{folder}: the page is not well-formed: {page.faults[:3]}")
        expect("script" not in page.tags, f"{folder}: a script is in the page")
        expect(all(link.startswith("data:image/png;base64,") for link in page.links),
               f"{folder}: the page links to something")
        expect(not re.search(r"https?:|url\(|@import", source), f"{folder}: the page needs something from outside")
        for svg in re.findall(r"<svg.*?</svg>", source, re.DOTALL):
            xml.etree.ElementTree.fromstring(svg)
        return page, source

    def finished(self):
        folder = self.run("finished", ranks=2)
        rows = list(csv.DictReader((folder / "history.csv").open(encoding="utf-8")))
        status, told = self.status(folder), json.loads((folder / "status.json").read_text(encoding="utf-8"))
        expect(status["state"] == told["state"] == "finished", f"finished: {status['state']}")
        expect(status["title"] == told["title"] == TITLE, "finished: another title")
        expect(status["step"] == int(rows[-1]["step"]) and near(status["time"], 0.05), "finished: another step or time")
        for key, column in {"mass": "mass [kg]", "dt": "dt [s]", "imbalance": "imbalance", "particles": "particles",
                            "rejected_steps": "rejected_steps", "trials": "trials",
                            "kinetic_energy": "kinetic_energy [J]", "elastic_energy": "elastic_energy [J]"}.items():
            expect(near(status[key], float(rows[-1][column])), f"finished: {key} is {status[key]}, not {rows[-1][column]}")
        energies = [f"{name}_energy [J]" for name in ("kinetic", "elastic", "gravitational", "dissipated")]
        change = sum(float(rows[-1][name]) - float(rows[0][name]) for name in energies)
        expect(near(status["energy_change"], change), f"finished: energy change {status['energy_change']}, not {change}")
        account, first = status["energy_account"], rows[0]
        parts = [sum(status[f"{name}_energy"] - float(first[f"{name}_energy [J]"]) for name in ("kinetic", "elastic", "dissipated")),
                 account["to_grid_and_integration_loss"], account["from_grid_loss"], account["removed_energy"],
                 *account["contact_losses"].values(), -account["gravity_work"],
                 *(-work for work in account["contact_works"].values())]
        expect("plate" in account["contact_losses"], "finished: no contact with the plate in the account")
        expect(abs(sum(parts)) < 1e-4 * max(map(abs, parts)), f"finished: the energy account leaves {sum(parts)} of {parts}")
        limited = [row["limiter"] for row in rows if row["limiter"] != "start"]
        for name, share in status["limiter_shares"].items():
            expect(near(share, limited.count(name) / len(limited)), f"finished: share of {name} is {share}")
        expect(near(sum(status["limiter_shares"].values()), 1.0), "finished: shares do not add up")
        files = [file for file in folder.iterdir() if file.is_file()]
        expect(status["disk"]["total"] == sum(file.stat().st_size for file in files), "finished: disk use")
        expect(status["disk"]["checkpoints"] == sum(f.stat().st_size for f in files if f.name.startswith("checkpoint_")),
               "finished: disk use of checkpoints")
        expect(status["frames"] == len(list(folder.glob("frame_*.h5"))), "finished: number of frames")
        expect(len(told["phases"]) > 5 and all(p["mean"] <= p["largest"] for p in told["phases"]), "finished: phases")
        self.finished_page(folder, rows)

    def finished_page(self, folder, rows):
        (folder / "pictures").mkdir()
        (folder / "pictures" / "view.png").write_bytes(PIXEL)
        (folder / "not_a_picture.png").write_text("http://example.org")
        page, source = self.page(folder)
        expect(len(page.links) == 1 and base64.b64decode(page.links[0].split(",")[1]) == PIXEL, "finished: the picture")
        expect(TITLE in page.text, "finished: the page does not have the title")
        kinetic = [float(row["kinetic_energy [J]"]) for row in rows]
        shown = re.search(r"<title>kinetic: (\S+) to (\S+)</title>", source)
        expect(shown and [float(shown[k]) for k in (1, 2)] == [float(f"{f(kinetic):.3g}") for f in (min, max)],
               f"finished: the curve of kinetic energy has another range than {min(kinetic)} to {max(kinetic)}")
        for word in ("Force on plate", "Torque on plate", "Time by phase of the step", "sigma_Y", "PETSc",
                     "checkpoint_0000"):
            expect(word in page.text, f"finished: the page lacks '{word}'")
        self.check_curve(source, kinetic)
        expect("other contacts" in self.check_losses("finished"), "finished: the wall that the ball brushes is not told with others")

    def check_curve(self, source, kinetic):
        """Heights of the curve, taken back through the axis, are the values of the table."""
        figure = re.search(r"<figcaption>Energies.*?</svg>", source, re.DOTALL)[0]
        path = re.search(r'<title>kinetic: [^<]*</title>\s*<path d="([^"]*)"', figure)[1]
        heights = [float(height) for height in re.findall(r"[ML] \S+ (\S+)", path)]
        expect(len(heights) == len(kinetic), f"the curve has {len(heights)} points for {len(kinetic)} rows")
        high, low = kinetic.index(max(kinetic)), kinetic.index(min(kinetic))
        scale = (heights[low] - heights[high]) / (kinetic[high] - kinetic[low])
        worst = max(abs(heights[high] + scale * (kinetic[high] - value) - y) for value, y in zip(kinetic, heights))
        expect(worst < 0.3, f"the curve of kinetic energy is {worst} off")

    def check_losses(self, name):
        """What `status` says of transfers and contacts is what the last row of the table has: each pass apart where it is known,
        and small contacts together."""
        line = re.search(r"went to +(.*)", self.ask("status", name))[1]
        last = list(csv.DictReader((self.work / name / "history.csv").open(encoding="utf-8")))[-1]
        to_grid, time_integration, either, from_grid = (float(last[f"{term}_loss [J]"]) for term in (
            "to_grid", "time_integration", "to_grid_and_integration", "from_grid"))
        if math.isfinite(to_grid):
            told = re.search(r", transfers (\S+) J \(\S+ %\): (\S+) to the grid, (\S+) from it, time integration (\S+) J", line)
            wanted = to_grid + from_grid, to_grid, from_grid, time_integration
        else:
            told = re.search(r", transfers and time integration (\S+) J \(\S+ %\): (\S+) from the grid", line)
            wanted = either + from_grid, from_grid
        expect(told and from_grid != 0.0 and all(abs(float(text) - number) <= 0.01 * abs(number)
                                                 for text, number in zip(told.groups(), wanted)), f"{name}: {line} for {wanted}")
        lost = {column.split(".")[0]: float(value) for column, value in last.items() if column.endswith(".contact_loss [J]")}
        named = {contact: float(number) for contact, number in re.findall(r"contact (\S+) (\S+) J", line)}
        others = sum(loss for contact, loss in lost.items() if contact not in named)
        said = re.search(r", other contacts (\S+) J", line)
        expect(near(float(said[1]) if said else 0.0, others, 0.01) and all(near(number, lost[contact], 0.01) for contact, number in named.items()),
               f"{name}: {line} for {lost}")
        return line

    def without_python(self):
        """No page, and a sentence that tells why; the summary of `status` needs no Python."""
        for python in ("/bin/false", "/nowhere/python3"):
            os.environ["BULKLEY_PYTHON"] = python
            text = self.ask("report", "finished", "--out", "no_page.html", code=3)
            expect("no page no_page.html: " in text and not (self.work / "no_page.html").exists(), f"{python}: {text}")
            expect(": finished (" in self.ask("status", "finished"), "status needs Python")
        expect("no python3 with matplotlib was found" in text and text.count("\n") == 1, f"without Python: {text}")
        # A Python that lacks matplotlib; the one on the PATH is passed over for the next.
        bare = self.work / "bare"
        bare.mkdir()
        (bare / "python3").write_text(f'#!/bin/sh\nexec {sys.executable} -S -E "$@"\n', encoding="utf-8")
        (bare / "python3").chmod(0o755)
        os.environ["BULKLEY_PYTHON"] = str(bare / "python3")
        text = self.ask("report", "finished", "--out", "no_page.html", code=3)
        expect("no python3 with matplotlib was found" in text and text.count("\n") == 1, f"without matplotlib: {text}")
        del os.environ["BULKLEY_PYTHON"]

    def running(self):
        """Looked at while it goes on; where it is stopped its bits must be those of a run left alone."""
        folder = self.work / "watched"
        process = subprocess.Popen([self.program.path, "run", str(SCENE), "--out", "watched", "--quiet", *ENDLESS],
                                   cwd=self.work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + LIMIT
        while not (folder / "history.csv").exists() and time.monotonic() < end:
            time.sleep(0.01)
        watch = subprocess.Popen([self.program.path, "status", "watched", "--watch", "0.2"], cwd=self.work,
                                 stdout=subprocess.PIPE, text=True)
        steps = []
        for _ in range(2):
            status = self.status(folder)
            expect(status["state"] == "running", f"watched: is {status['state']}")
            steps.append(status["step"])
            self.page(folder, "--out", "watched.html")
        folder.joinpath("STOP").touch()
        expect(process.wait(LIMIT) == 4, "watched: the run did not stop well")
        expect(steps == sorted(steps) and steps[0] < steps[-1], f"watched: the steps seen are {steps}")
        text, _ = watch.communicate(timeout=LIMIT)
        expect(watch.returncode == 0 and "watched: running, t = " in text and ": stopped (" in text,
               f"watched: --watch said {text}")
        last = str(self.status(folder)["step"])
        alone = self.run("alone", *ENDLESS, "--max-steps", last)
        expect("identical" in self.ask("compare", str(folder), str(alone)), "watched: other bits than a run left alone")
        print(f"seen at steps {steps}, stopped at {last}")

    def stopped(self):
        apic = ("--set", "transfer.scheme=apic")
        folder = self.run("stopped", "--max-steps", "60", *apic)
        expect(self.status(folder)["state"] == "finished", "--max-steps ends a run")
        folder.joinpath("STOP").touch()
        self.run("stopped", "--restart", "--set", "time.end=5", *apic, code=4)
        text = self.ask("status", "stopped")
        told = json.loads((folder / "status.json").read_text(encoding="utf-8"))
        expect(": stopped (" in text and "continue with: mpirun -n 1 bulkley run" in text, f"stopped: {text}")
        expect(told["first_step"] == 60, f"stopped: this part began at {told['first_step']}")
        page, _ = self.page(folder)
        expect("continue with: mpirun" in page.text, "stopped: the page does not say how to go on")
        self.check_losses("stopped")

    def failed(self):
        folder = self.run("failed", "--set", "time.smallest_volume_ratio=0.99", code=3)
        text = self.ask("status", "failed")
        expect(": failed (" in text and "volume" in text, f"failed: {text}")
        page, _ = self.page(folder)
        expect(json.loads((folder / "status.json").read_text(encoding="utf-8"))["reason"] in page.text, "failed: no reason")

    def killed_and_torn(self):
        folder = self.work / "torn"
        shutil.copytree(self.work / "finished", folder)
        before = self.status(folder)
        whole = (folder / "history.csv").read_text(encoding="utf-8")
        row = "999999,1e9," + whole.split("\n")[-2].split(",", 2)[2]
        for cut in (row[:40], row[:-1]):  # the second has all its cells, but not all digits of the last
            (folder / "history.csv").write_text(whole + cut, encoding="utf-8")
            expect(self.status(folder)["step"] == before["step"], "torn: the cut row counts")
        _, source = self.page(folder)
        expect("1e+09" not in source, "torn: the cut row is drawn")
        status = json.loads((folder / "status.json").read_text(encoding="utf-8"))
        (folder / "status.json").write_text(json.dumps({**status, "state": "running"}), encoding="utf-8")
        expect(self.status(folder)["state"] == "running", "a run that wrote a moment ago runs")
        for file in folder.iterdir():
            os.utime(file, (time.time() - 3600, time.time() - 3600))
        text = self.ask("status", "torn")
        for word in (": silent (", "nothing has been written for 1h00m", "continue with: mpirun -n 2 bulkley run"):
            expect(word in text, f"torn: no '{word}' in {text}")
        (folder / "status.json").unlink()
        expect(self.status(folder)["state"] == "unknown", "torn: a state without status.json")
        self.page(folder)
        (folder / "history.csv").write_text((folder / "history.csv").read_text(encoding="utf-8").split("\n")[0] + "\n0,0,",
                                            encoding="utf-8")
        self.page(folder)  # a table without rows
        self.ask("status", "torn")

    def watched_in_vain(self):
        """--watch ends where a run writes nothing, by what the run or the user has stated; it goes on where neither bounds it."""
        folder = self.work / "lost"
        shutil.copytree(self.work / "finished", folder)
        status = json.loads((folder / "status.json").read_text(encoding="utf-8"))
        expect(status["longest_silence"] == 660.0, f"lost: longest_silence is {status['longest_silence']}")

        def watch(age, bound, *options, code=3):
            text = json.dumps({**status, "state": "running", **({} if bound is None else {"longest_silence": bound})})
            (folder / "status.json").write_text(text, encoding="utf-8")
            for file in folder.iterdir():
                os.utime(file, (time.time() - age, time.time() - age))
            process = subprocess.Popen([self.program.path, "status", "lost", "--watch", "0.1", *options], cwd=self.work,
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            try:
                text, _ = process.communicate(timeout=4.0 if code is None else LIMIT)
            except subprocess.TimeoutExpired:
                process.kill()
                text, _ = process.communicate()
                expect(code is None, f"lost: {age} s silent, {bound}, {options}: watched on: {text}")
                return
            expect(process.returncode == code, f"lost: {age} s silent, {bound}, {options}: {process.returncode}: {text}")
            expect(text.count("lost: has written nothing for") == 1 and "watched no longer" in text, f"lost: {text}")

        watch(3600, None)
        watch(300, None, code=None)
        watch(300, None, "--patience", "4m")
        watch(3600, None, "--patience", "2h", code=None)
        watch(3600, 0.0, code=None)
        del status["longest_silence"]  # as an earlier version wrote it
        watch(3600, None)
        text = self.ask("status", "lost", "--patience", "4m", code=2)
        expect("--patience is for --watch" in text and text.count("\n") == 1, f"lost: {text}")

    def not_set_up(self):
        """A run that fails before its first step says so in its folder, which is free for the next; one that cannot be continued
        keeps what it was."""
        outside = ["--set", "bodies.ball.velocity=[0,0,-2]", "--set", "bodies.ball.shape.center=[0.2,0.2,0.03]"]
        folder = self.run("outside", *outside, "--set", "time.largest_step=1", ranks=2, code=2)
        told = json.loads((folder / "status.json").read_text(encoding="utf-8"))
        expect(told["state"] == "failed" and told["failed_in_set_up"] and "ball" in told["reason"] and
               "outside" in told["reason"], f"outside: {told}")
        expect(any("time.largest_step" in warning for warning in told["warnings"]), f"outside: warnings {told['warnings']}")
        expect(": failed (" in self.ask("status", "outside"), "outside: status")
        self.run("outside", "--max-steps", "10")
        told = json.loads((folder / "status.json").read_text(encoding="utf-8"))
        expect(told["state"] == "finished" and "failed_in_set_up" not in told, f"outside: as it should be, {told}")
        self.run("outside", *outside, code=2)  # a run is there now
        self.run("outside", "--restart", "--set", "gravity=[0,0,-5]", code=2)
        expect(json.loads((folder / "status.json").read_text(encoding="utf-8")) == told, "outside: a refusal changed status.json")
        checkpoint = folder / "checkpoint_000000010.h5"
        checkpoint.write_bytes(checkpoint.read_bytes()[:5000])
        self.run("outside", "--restart", str(checkpoint), code=3)
        damaged = json.loads((folder / "status.json").read_text(encoding="utf-8"))
        expect(damaged["state"] == "failed" and checkpoint.name in damaged["reason"], f"outside: damaged, {damaged}")
        expect({**damaged, "state": told["state"], "reason": told["reason"]} == told, f"outside: not as before: {damaged}")

    def foreign(self):
        (self.work / "empty").mkdir()
        for command in ("status", "report"):
            for name, word in {"empty": "holds no run", "nowhere": "no such folder", str(SCENE): "not a folder"}.items():
                text = self.ask(command, name, code=2)
                expect(word in text and text.count("\n") == 1, f"{command} {name}: {text}")
        expect(not list((self.work / "empty").iterdir()), "something was written into a foreign folder")
        text = self.ask("report", "finished", "--out", "nowhere/page.html", code=2)
        expect("--out names another place" in text, f"report: {text}")

    def several(self):
        lines = self.ask("status", "finished", "stopped", "failed").splitlines()
        expect([line.split()[1] for line in lines] == ["state", "finished", "stopped", "failed"], f"table: {lines}")
        expect(len(json.loads(self.ask("status", "--json", "finished", "failed"))) == 2, "several: JSON")

    def long(self, n_rows):
        """A long table in bounded memory; a spike of one row must be drawn."""
        folder = self.work / "long"
        shutil.copytree(self.work / "finished", folder)
        header, first, *_ = (folder / "history.csv").read_text(encoding="utf-8").split("\n")
        cells = first.split(",")
        at = header.split(",").index("kinetic_energy [J]")
        with (folder / "history.csv").open("w", encoding="utf-8") as file:
            file.write(header + "\n")
            for row in range(n_rows):
                cells[0], cells[1] = str(row), repr(row * 1e-6)
                cells[at] = "12345" if row == n_rows // 3 else repr(row * 1e-5)
                file.write(",".join(cells) + "\n")
        begin = time.monotonic()
        self.status(folder)
        asked = time.monotonic() - begin
        _, source = self.page(folder)
        drawn = time.monotonic() - begin - asked
        print(f"{n_rows} rows: status {asked:.2f} s, page {drawn:.2f} s, {len(source) / 1e6:.2f} MB")
        expect("to 1.23e+04</title>" in source, "long: the spike is lost")
        expect(len(source) < 1_000_000, f"long: the page has {len(source)} bytes")


def main():
    arguments = bulkley_program.parse_arguments(
        __doc__, lambda parser: parser.add_argument("--rows", type=int, default=50000, help="of the long table"))
    program, work = bulkley_program.start(arguments)
    monitor = Monitor(program, work)
    monitor.finished()
    monitor.stopped()
    monitor.failed()
    monitor.killed_and_torn()
    monitor.watched_in_vain()
    monitor.not_set_up()
    monitor.foreign()
    monitor.without_python()
    monitor.several()
    monitor.long(arguments.rows)
    monitor.running()


if __name__ == "__main__":
    main()
