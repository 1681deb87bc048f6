"""Runs, their records and sweeps: see the package's own words."""

import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import weakref


class Error(Exception):
    """What the program says of an experiment, a study or a record that it refuses, or of a device that failed."""


def program():
    """The program: $SKEIN, else that of the tree that this package stands in, else `skein` on the path."""
    asked = os.environ.get("SKEIN")
    if asked:
        return asked
    tree = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
    for build in ("release", "dev", "headless"):
        built = os.path.join(tree, "build", build, "bin", "skein")
        if os.access(built, os.X_OK):
            return built
    found = shutil.which("skein")
    if not found:
        raise Error("there is no program skein: install it, build it, or name it in $SKEIN")
    return found


def _text(value):
    """A text in TOML's quotes."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _whole(value):
    """An array of numpy's has one kind of numbers: those of robots in it are whole all the same."""
    if isinstance(value, list):
        return [_whole(below) for below in value]
    return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < 1e15 else value


def _toml(value):
    """A value as TOML writes it."""
    if hasattr(value, "tolist"):  # a number or an array of numpy's
        value = _whole(value.tolist())
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return _text(os.fspath(value))
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, dict):
        pairs = [f"{_key(str(key))} = {_toml(below)}" for key, below in value.items()]
        return "{ " + ", ".join(pairs) + " }" if pairs else "{}"
    raise Error(f"{value!r} cannot be set; allowed: numbers, texts, True, False, and lists, arrays and dicts of them")


def _key(name):
    return name if re.fullmatch("[A-Za-z0-9_-]+", name) else _text(name)


def _sets(set):
    words = []
    for key, value in (set or {}).items():
        try:
            words += ["--set", f"{key}={_toml(value)}"]
        except Error as refused:
            raise Error(f"{key}: {refused}") from None
    return words


_held = set()  # our ends of the pipes that running programs watch


def _release(held):
    if held in _held:
        _held.discard(held)
        os.close(held)


# A child of this Python must not hold a run that is not its own.
os.register_at_fork(after_in_child=lambda: [_release(held) for held in list(_held)])


def _pass_on(complaints, lines):
    """What the program complains of is told at once, and kept."""
    with complaints:
        for line in complaints:
            lines.append(line)
            if sys.stderr:
                sys.stderr.write(line)
                sys.stderr.flush()


def _end(child):
    """Ends a run and waits until its robots stand, however often somebody presses Ctrl-C meanwhile."""
    told = False
    while child.poll() is None:
        try:
            if not told:
                child.terminate()
            told = True
            child.wait()
        except KeyboardInterrupt:
            pass


def _result(words):
    """Runs the program: its exit status, what it printed and what it complained of, line by line. The run ends when this
    Python ends, even by SIGKILL: that closes `held`, and the program watches the other end."""
    watched, held = os.pipe()
    _held.add(held)
    child, listener, lines = None, None, []
    try:
        with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as printed:
            try:
                child = subprocess.Popen(
                    [program(), *words],
                    stdin=subprocess.DEVNULL,
                    stdout=printed,
                    stderr=subprocess.PIPE,
                    encoding="utf-8",
                    errors="replace",
                    pass_fds=[watched],
                    env={**os.environ, "SKEIN_WHILE_OPEN": str(watched)},
                )
            except OSError as refused:
                named = " ($SKEIN)" if os.environ.get("SKEIN") else ""
                raise Error(f"{program()}{named} cannot be started: {refused.strerror}") from refused
            listener = threading.Thread(target=_pass_on, args=(child.stderr, lines), daemon=True)
            listener.start()
            child.wait()
            listener.join()
            printed.seek(0)
            return child.returncode, printed.read(), lines
    finally:
        _release(held)
        os.close(watched)
        if child:
            _end(child)
        if listener:
            listener.join()


def _start(words, folder):
    """Runs the program. Returns its summary and what it complained of; exit status 1 is no error: an expectation failed.
    `folder`: for the moment; gone where the program refuses."""
    try:
        status, printed, lines = _result(words)
        problems = [line.rstrip("\n").removeprefix("skein: ") for line in lines if line.strip()]
        if status not in (0, 1):
            ended = f"was ended by signal {-status}" if status < 0 else f"ended with status {status}"
            raise Error("\n".join(problems) or f"skein {ended}")
        try:
            return json.loads(printed), status == 0, problems
        except ValueError as other:
            raise Error(f"{program()} printed no summary: it is not this package's skein") from other
    except BaseException:
        shutil.rmtree(folder or "", True)
        raise


class _Whole(io.RawIOBase):
    """A file up to where a power cut tore it: half a row, whose last number reads as another one, or zeros. Whole rows at a
    time, since a record may be larger than the memory."""

    def __init__(self, file):
        self._file, self._ready, self._rest, self._ended = file, b"", bytearray(), False
        self.torn = False  # known at the end

    def readable(self):
        return True

    def readinto(self, buffer):
        while not self._ready and not self._ended:
            block = self._file.read(1 << 20)
            zeros = block.find(b"\0")
            self._ended = not block or zeros >= 0
            if zeros >= 0:
                block = block[:zeros]
            end = block.rfind(b"\n") + 1
            if end:
                self._ready, self._rest = bytes(self._rest) + block[:end], bytearray()
            self._rest += block[end:]
            self.torn = self._ended and (zeros >= 0 or len(self._rest) > 0)
        size = min(len(buffer), len(self._ready))
        buffer[:size], self._ready = self._ready[:size], self._ready[size:]
        return size


def _joined(pandas, parts):
    """One table of its parts. The columns are joined one at a time, and their parts are free then."""
    columns = {}
    for count, table in enumerate(parts, 1):
        for name in table.columns:
            columns.setdefault(name, []).append(table[name].copy())
    if count == 1:
        return table
    del table
    for name, pieces in columns.items():
        columns[name] = pandas.concat(pieces, ignore_index=True)
        pieces.clear()
    return pandas.DataFrame(columns, copy=False)


class _Table:
    """A CSV file, read when it is first looked at."""

    def __init__(self, file, folder=None):
        self.file = os.fspath(file)
        self._remove = weakref.finalize(self, shutil.rmtree, folder, True) if folder else None  # a folder for the moment
        self._data = None

    def _head_lines(self):
        try:
            with open(self.file, encoding="utf-8-sig") as lines:  # other programs save it with a byte order mark
                count = 0
                for line in lines:
                    if not line.startswith("#"):
                        names = line.rstrip("\r\n").split(",")
                        if not all(re.fullmatch(r"[^\s=\[\]{}\"]+", name) for name in names):
                            raise Error(f"{self.file}: line {count + 1} is no row of column names: it is no record")
                        return count, names
                    count += 1
        except OSError as refused:
            raise Error(f"{self.file}: cannot be read: {refused.strerror}") from refused
        except UnicodeDecodeError as refused:
            raise Error(f"{self.file}: is no text: it is no record") from refused
        raise Error(f"{self.file}: ends before a header row")

    @property
    def columns(self):
        """Names of the columns, in their order."""
        return self._head_lines()[1]

    @property
    def data(self):
        """All of it as a pandas.DataFrame, to the bit."""
        if self._data is None:
            try:
                import pandas
            except ImportError as missing:
                raise Error("reading a table needs pandas: install python3-pandas") from missing
            lines, names = self._head_lines()
            words = {n: str for n in names if n == "event" or n.split("_", 1)[-1] in ("mode", "how", "link", "limit")}
            # Part by part: at once pandas needs several times the memory of the table, and the text besides.
            part = max(1000, 1_000_000 // len(names))
            try:
                with open(self.file, "rb") as file:
                    whole = _Whole(file)
                    parts = pandas.read_csv(
                        io.BufferedReader(whole),
                        skiprows=lines,
                        dtype=words,
                        keep_default_na=False,
                        na_values=[""],
                        float_precision="round_trip",
                        chunksize=part,
                    )
                    self._data = _joined(pandas, parts)
            except ValueError as refused:  # a row with too many cells, bytes that are no text
                raise Error(f"{self.file}: {refused}") from refused
            if whole.torn and sys.stderr:
                sys.stderr.write(f"skein: {self.file}: the file is torn at its end, as by a power cut: read up to the torn row\n")
        return self._data

    def __getitem__(self, column):
        """A column as a numpy array."""
        return self.data[column].to_numpy()


class Run(_Table):
    """A run: `summary` (a dict; None of a record that was read), `ok` (whether the file's [expect] held; None of a record
    that was read, and of a kept run that did not end), `problems` (sentences), and its record: `file`, `columns`, `data`,
    `run["r1_x"]`, `experiment`, `robots`, `events`, `plot()`."""

    def __init__(self, file, summary=None, ok=None, problems=(), folder=None):
        super().__init__(file, folder)
        self.summary = summary
        self.ok = ok
        self.problems = list(problems)

    def __repr__(self):
        return f"<skein.Run {self.file}{'' if self.ok is None else ', ok' if self.ok else ', not ok'}>"

    @property
    def experiment(self):
        """The text of the experiment that the record embeds."""
        with open(self.file, encoding="utf-8-sig") as lines:
            text = []
            for line in lines:
                if not line.startswith("#"):
                    break
                if line.startswith("#| "):
                    text.append(line[3:])
        return "".join(text)

    @property
    def robots(self):
        """How many there are."""
        names = set(self.columns)
        count = 0
        while f"r{count + 1}_x" in names:
            count += 1
        return count

    @property
    def events(self):
        """(t, what) of everything that happened."""
        rows = self.data[["t", "event"]].dropna()
        return [(t, what) for t, cell in rows.itertuples(index=False) for what in cell.split("; ")]

    def save(self, file):
        """Keeps the record, which is gone with this object where `run` was not given a csv=."""
        shutil.copyfile(self.file, file)
        self.file = os.fspath(file)
        if self._remove:
            self._remove()

    def plot(self, figure=None):
        """Paths, tracking errors and errors of the formation. Returns the matplotlib figure."""
        try:
            import matplotlib.pyplot as plt
        except ImportError as missing:
            raise Error("plotting needs matplotlib: install python3-matplotlib") from missing
        data = self.data
        data = data[~data["r1_mode"].fillna("").str.contains("staging")]  # on the way to the starts t stands still
        figure = figure or plt.figure(figsize=(11, 5), constrained_layout=True)
        grid = figure.add_gridspec(2, 2)
        floor, tracking, formation = (figure.add_subplot(part) for part in (grid[:, 0], grid[0, 1], grid[1, 1]))
        for i in range(1, self.robots + 1):
            (line,) = floor.plot(data[f"r{i}_x"], data[f"r{i}_y"], label=f"robot {i}")
            floor.plot(data[f"r{i}_x_nom"], data[f"r{i}_y_nom"], color=line.get_color(), linestyle=":", linewidth=1)
            error = (data[f"r{i}_x_e"] ** 2 + data[f"r{i}_y_e"] ** 2) ** 0.5
            tracking.plot(data["t"], 1e3 * error, color=line.get_color())
        for name in data.columns:
            if name.startswith("delta_"):
                formation.plot(data["t"], 1e3 * data[name], label=name)
        floor.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
        tracking.set(ylabel="tracking error [mm]")
        formation.set(xlabel="t [s]", ylabel="formation error (37) [mm]")
        floor.legend(fontsize="small")
        return figure


class Sweep(_Table):
    """A study's runs: `summary` (a dict), `ok`, `problems`, and its table: `data`, `sweep["min_distance"]`."""

    def __init__(self, file, summary, ok, problems, folder):
        super().__init__(file, folder)
        self.summary = summary
        self.ok = ok
        self.problems = list(problems)


def _place(csv, name):
    if csv is not None:
        return os.fspath(csv), None
    folder = tempfile.mkdtemp(prefix="skein-")
    return os.path.join(folder, name), folder


def run(experiment, set=None, *, duration=None, seed=None, csv=None, options=()):
    """Runs an experiment file and returns the Run. `set`: keys of the file and their values: numbers, texts, lists, numpy
    arrays, dicts (tables). `csv`: where the
    record is kept; without it, it is gone with the Run. `options`: further words of `skein run`, such as
    ["--keep"]. Raises Error where the experiment is refused or a device fails; an expectation of the file that
    fails is `run.ok == False`, with sentences in `run.problems`."""
    file, folder = _place(csv, "run.csv")
    words = ["run", os.fspath(experiment), "--json", "--csv", file, *_sets(set), *options]
    if duration is not None:
        words += ["--duration", _toml(duration)]
    if seed is not None:
        words += ["--seed", str(seed)]
    summary, ok, problems = _start(words, folder)
    return Run(file, summary, ok, problems, folder)


def read(file):
    """A record that was made before: a CSV of `skein run --csv` or of the window, or the folder of a run that was kept."""
    file = os.fspath(file)
    if os.path.isdir(file):
        told = os.path.join(file, "run.json")
        try:
            with open(told, encoding="utf-8") as story:
                kept = json.load(story)
        except OSError as refused:
            raise Error(f"{file}: is not the folder of a run that was kept: {told}: {refused.strerror}") from refused
        except (ValueError, RecursionError) as refused:
            raise Error(f"{told}: {refused}") from refused
        if not isinstance(kept, dict):
            raise Error(f"{told}: is not a JSON object, allowed: a file written by `skein run --keep`")
        status, problems = kept.get("exit_status"), kept.get("problems")
        ok = None if status is None else status == 0  # None: the run did not end
        return Run(os.path.join(file, "run.csv"), kept.get("summary"), ok, problems if isinstance(problems, list) else ())
    if not os.path.isfile(file):
        raise Error(f"{file}: there is no such file")
    return Run(file)


def sweep(study, set=None, *, runs=None, seed=None, threads=None, csv=None):
    """Runs a study file (docs/studies.md) and returns the Sweep: `data` has a row for each run, and a second one with its
    control if the study has one; the column `variant` tells them apart."""
    file, folder = _place(csv, "sweep.csv")
    words = ["sweep", os.fspath(study), "--json", "--csv", file, *_sets(set)]
    for option, value in (("--runs", runs), ("--seed", seed), ("--threads", threads)):
        if value is not None:
            words += [option, str(value)]
    summary, ok, problems = _start(words, folder)
    return Sweep(file, summary, ok, problems, folder)
