"""One run of `skein` against emulated robots, and how far each drove blind. Python's standard library alone."""
import contextlib
import fcntl
import os
import pathlib
import re
import select
import signal
import subprocess
import sys
import tempfile
import termios
import threading
import time

metres_per_step = 0.041 * 3.141592653589793 / 1000
WHEELS = re.compile(r"([\d.]+) robot (\d+): wheels (-?[\d.]+) (-?[\d.]+)")


class Failed(Exception):
    pass


def wait_until(what, condition, seconds=30.0):
    """`what`: for the message of a failure, or a function that then returns it."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise Failed(f"waited {seconds:g} s in vain: {what() if callable(what) else what}")
        time.sleep(0.002)


def lives(process):
    """Whether nothing has ended it yet. It commands nobody from then on, long before it is gone: its memory and its files go first."""
    exiting, signalled = 0x4, 0x400  # PF_EXITING, PF_SIGNALED of the kernel
    try:
        fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return False
    return fields[0] not in "ZX" and not int(fields[6]) & (exiting | signalled)


def ended_by_the_kernel(process, since, seconds=30.0):
    """When it was last seen to live, before the kernel ended it: `since` if it was gone at the first look."""
    end = time.monotonic() + seconds
    while (now := time.monotonic()) < end:
        if not lives(process):
            return since
        since = now
        time.sleep(0.001)
    raise Failed(f"waited {seconds:g} s in vain: the kernel ends the run")


class Robots:
    """`skein emulate`: every change of a wheel with its time."""

    def __init__(self, skein, folder, count=2, faults=None, name="robots"):
        self.folder = folder / name
        self.count = count
        self.changes = [[] for _ in range(count)]  # of each robot: (time, left, right), on this program's clock
        words = [skein, "emulate", "--verbose", "--robots", str(count), "--directory", str(self.folder)]
        if faults:
            path = folder / (name + "-faults.toml")
            path.write_text(faults)
            words += ["--faults", str(path)]
        # A session of its own: what is done to a run's terminal or group is not done to its robots.
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, start_new_session=True)
        self.offset = float("inf")
        self.ready = 0
        self.started = time.monotonic()
        threading.Thread(target=self._read, daemon=True).start()
        wait_until("emulated robots", lambda: self.ready == count)

    def _read(self):
        for line in self.process.stdout:
            now = time.monotonic()
            if match := WHEELS.match(line):
                at = float(match[1])
                # A line comes late, never early: the smallest difference is the two clocks'.
                self.offset = min(self.offset, now - at)
                self.changes[int(match[2]) - 1].append((at, float(match[3]), float(match[4])))
            elif line.startswith("robot "):
                self.ready += 1

    def address(self, robot):
        return f"serial:{self.folder}/robot{robot}"

    def drives(self, robot):
        changes = self.changes[robot - 1]
        return bool(changes) and (changes[-1][1] != 0 or changes[-1][2] != 0)

    def all_drive(self):
        return all(self.drives(i + 1) for i in range(self.count))

    def all_stand(self):
        return not any(self.drives(i + 1) for i in range(self.count))

    def blind(self, since, whose=None):
        """Of the worst robot: seconds and metres from `since` until it stood for good."""
        worst = (0.0, 0.0)
        for robot in whose or range(1, self.count + 1):
            last, way, speed, stood = since, 0.0, 0.0, since
            for at, left, right in list(self.changes[robot - 1]):
                at += self.offset
                if at > last:
                    way += speed * (at - last)
                    last = at
                    if left == 0 and right == 0 and speed > 0:
                        stood = at
                speed = max(abs(left), abs(right)) * metres_per_step
            if speed > 0:
                return (float("inf"), float("inf"))
            worst = max(worst, (stood - since, way))
        return worst

    def end(self):
        self.process.kill()
        self.process.wait()


class Logind:
    """A message bus with a logind that grants every inhibitor."""

    def __init__(self, program):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        self.inhibitors = 0
        self.down = False
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            if line == "down\n":
                self.down = True
            else:
                self.inhibitors = int(line)

    def shut_down(self):
        """From now on the machine is about to be shut down; `down`: nobody delays that any more."""
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def end(self):
        self.process.stdin.close()
        self.process.wait()


class Lab:
    """A folder with experiment, pictures and state of its own."""

    def __init__(self, skein, pictures, logind):
        self.skein = skein
        self.logind_program = logind
        self.files = tempfile.TemporaryDirectory(prefix="skein-hostile-")
        self.folder = pathlib.Path(self.files.name)
        source = pathlib.Path(__file__).parent / "experiment.toml"
        subprocess.run([pictures, str(source), str(self.folder)], check=True)
        (self.folder / "pictures").mkdir()
        for n in range(1000, 2600):
            os.link(self.folder / "picture.pgm", self.folder / "pictures" / f"{n}.pgm")
        self.text = source.read_text()
        self.processes = []
        self.robots = []
        self.bus = None
        self.cases = 0

    def start_case(self):
        self.cases += 1
        self.case = self.folder / f"case{self.cases}"
        (self.case / "state").mkdir(parents=True, mode=0o700)
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith("XDG_")}
        self.environment.update(XDG_STATE_HOME=str(self.case / "state"), XDG_CONFIG_HOME=str(self.case / "config"),
                                XDG_DATA_HOME=str(self.case / "data"))

    def emulate(self, **words):
        robots = Robots(self.skein, self.case, **words)
        self.robots.append(robots)
        return robots

    def logind(self):
        """From now on runs speak to this one; None: there is no dbus-daemon."""
        self.bus = Logind(self.logind_program)
        if not self.bus.address:
            return None
        self.environment["DBUS_SYSTEM_BUS_ADDRESS"] = self.bus.address
        return self.bus

    def experiment(self, robots, name="experiment.toml"):
        path = self.case / name
        text = self.text.replace("serial:/nowhere", f"serial:{robots.folder}")
        text = text.replace("images:pictures", f"images:{self.folder}/pictures")
        path.write_text(text.replace('"camera.toml"', f'"{self.folder}/camera.toml"'))
        return path

    def run(self, robots, *words, program=None, wrap=(), terminal=False, background=False, setup=None, **pipes):
        """Starts `skein run` and waits until all robots drive."""
        command = [*wrap, str(program or self.skein), "run", str(self.experiment(robots)), *map(str, words)]
        log = open(self.case / "log", "ab")
        options = dict(stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        options.update(pipes)
        if terminal:
            self.master, slave = os.openpty()
            options.update(stdin=slave, stdout=slave, stderr=slave)

        def prepare():
            if terminal:
                fcntl.ioctl(0, termios.TIOCSCTTY, 0)
            if background:
                os.setpgid(0, 0)  # the terminal's foreground group stays the one that it was
            if setup:
                setup()

        process = subprocess.Popen(command, cwd=self.case, env=self.environment, preexec_fn=prepare, **options)
        self.processes.append(process)
        if terminal:
            os.close(slave)
            self.drains = True
            self.drain = threading.Thread(target=self._drain, daemon=True)
            self.drain.start()
        wait_until(lambda: "robots that drive: " + self.last_words(), lambda: robots.all_drive() or process.poll() is not None)
        if process.poll() is not None:
            raise Failed("the run ended by itself: " + self.last_words())
        time.sleep(0.3)  # in the middle of it
        return process

    def _drain(self):
        try:
            while self.drains:
                if select.select([self.master], [], [], 0.02)[0]:
                    os.read(self.master, 4096)
        except OSError:
            pass

    def close_terminal(self):
        """When that was. Nobody may be reading: the terminal would last as long."""
        self.drains = False
        self.drain.join()
        since = time.monotonic()
        os.close(self.master)
        return since

    def log(self):
        """All that runs have said in this case."""
        path = self.case / "log"
        return path.read_text(errors="replace") if path.exists() else ""

    def last_words(self):
        return self.log()[-600:]

    def hears(self, words, seconds=5.0):
        """Waits until a run has said this, whatever it has said since."""
        wait_until(lambda: f'"{words}" from the run, which said: {self.last_words()}', lambda: words in self.log(), seconds)

    def skein_says(self, *words, seconds=30.0):
        """Another `skein`, its exit status and what it said."""
        done = subprocess.run([self.skein, *map(str, words)], cwd=self.case, env=self.environment, text=True,
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds)
        return done.returncode, done.stdout + done.stderr

    def parents(self):
        """The parent of each process of the machine."""
        found = {}
        for entry in pathlib.Path("/proc").iterdir():
            with contextlib.suppress(OSError, ValueError):
                found[int(entry.name)] = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
        return found

    def guards(self):
        """The guards of this case: their markers are in its folder."""
        marker = f"SKEIN_GUARD_MARKER={self.case}/".encode()
        found = []
        for entry in pathlib.Path("/proc").iterdir():
            with contextlib.suppress(OSError, ValueError):
                if (entry / "comm").read_text() == "robot-guard\n" and (entry / "environ").read_bytes().startswith(marker):
                    found.append(int(entry.name))
        return found

    def guard_of(self, run):
        """The guard of the case's only run, or None."""
        guards = self.guards() if run.poll() is None else []
        return guards[0] if guards else None

    def markers(self):
        state = self.case / "state" / "skein"
        return [p for p in state.iterdir() if not p.name.endswith(".stop")] if state.exists() else []

    def end_case(self):
        for process in self.processes:
            if process.poll() is None:
                for what in (signal.SIGCONT, signal.SIGKILL):
                    os.kill(process.pid, what)
                process.wait()
        for guard in self.guards():
            with contextlib.suppress(ProcessLookupError):
                os.kill(guard, signal.SIGKILL)
        for robots in self.robots:
            robots.end()
        if self.bus:
            self.bus.end()
            self.bus = None
        self.processes, self.robots = [], []


def fail(sentence):
    print(sentence, file=sys.stderr)
