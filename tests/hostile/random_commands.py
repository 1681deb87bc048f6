"""A user who types at random: the commands, options and values of `skein`, on a machine where something may be amiss.

Whatever is typed, the program ends by itself or within seconds of a signal, with an exit status that is documented; it says why it
refuses, in its own words; it changes no file that it was not told to change, and leaves no draft and nothing in the folder for
temporary files.

usage: random_commands.py SKEIN RESOURCES; of the environment, as in the other random tests: SKEIN_CHAOS_SEED (1), SKEIN_CHAOS_RUNS (8),
SKEIN_CHAOS_TELL (unset): print every command line.
"""
import collections
import hashlib
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile

runs_alone = 12.0     # until a signal ends what does not end by itself [s]
ends_within = 20.0    # of that signal, on a busy machine; `robots stop` goes on trying for 14 s
documented = {0, 1, 2, 3}

Option = collections.namedtuple("Option", "name value needs required")
Command = collections.namedtuple("Command", "words options places")

# What real devices or the machine itself would have to be there for, or would be changed by.
never_typed = {"--help", "--version", "--schema", "--fix", "--adapter"}
never_run = [("robots", "scan"), ("robots", "pair"), ("guard",)]

inputs = ["e.toml", "study.toml", "run.csv", "loop.csv", "torn.csv", "link.csv", "film.mkv", "video:film.mkv", "video:torn.mkv", "images:folder", "runs", "last",
          "marks.toml", "robots.toml", "camera.toml", "empty", "binary", "latin.toml", "folder", "fifo", "dangling", "circle", "tags.pdf", "platoon", "crowds"]
outputs = ["new", "new.csv", "new/deep/x", "dangling", "circle", "folder", "fifo", "run.csv", "e.toml", "new.pdf", "new.svg", "new.mkv", "film.mkv", "", "."]
rubbish = ["", " ", "-", "--", "-1", "0", "3", "1e400", "nan", "inf", "0x10", "1,5", "99999999999999999999", "true", "é", "\n", "a\nb", "\x1b[2J", "%s%n", "a" * 5000,
           "/" * 300, "random", "1/3", "640x480", "duration=1", "x=", "=x", "'; drop table runs", "("]
numbers = ["0", "1", "2", "5", "0.5", "10", "40", "-1", "1e-9", "1e9", "25"]
settings = ["duration=1", "duration=0.04", "rate=50", "seed=3", "perturb=[]", "robot=[{tag=1}]", "robot=[]", "avoidance.kind=plan", "controller.gains.k_xx=0.001",
            "controller.coupling=bounded", "simulation.pose_noise=0.01", "robot_defaults.link=loopback", "camera.source=synthetic", "camera.source=video:film.mkv",
            "camera.film=small", "arena=[0.1,0.1]", "expect.final_error=0", "controller.law=nothing", 'name="a/b"', "simulation.latency=1", "tags.size=0.01"]
values = {
    "experiment": ["e.toml", "platoon", "open-loop", "platoon-loopback", "two-cameras", "latin.toml", "run.csv"],
    "study": ["study.toml", "study.toml", "coupling"],
    "run": ["run.csv", "loop.csv", "torn.csv", "last", "link.csv"],
    "source": ["video:film.mkv", "video:torn.mkv", "images:folder"],
    "ids": ["1-4", "3", "1,1", "586"],
    "robots": ["e.toml", "robots.toml", "a", "tcp:127.0.0.1:1", "serial:/dev/null"],
    "query": ["k_xx > 0.001", "collisions = 0", "collisions", "name ~ plat"],
    "camera": ["v4l2:/dev/video99", "aravis:nobody"],
    "--set": settings, "--camera": ["camera.toml", "e.toml"], "--calibration": ["camera.toml"], "--marks": ["marks.toml"], "--merge": ["parts", "folder"],
    "--part": ["1/2", "3/2", "auto"], "--publish": ["udp:localhost:9870", "udp:nowhere.invalid:3"], "--file": ["robots.toml", "new.toml", "e.toml"],
    "--runs-dir": ["runs", "folder", "new"], "--tags": ["1-4", "7"], "--listen": ["tcp:127.0.0.1:0", "udp:127.0.0.1:0"], "--where": ["collisions = 0"], "--faults": ["random"],
}

# What is amiss with the machine, as a shell says it. A signal comes early.
surroundings = {"all is well": "", "well again": "", "still well": "", "stdout is full": "exec >/dev/full", "stdout is closed": "exec >&-", "stderr is closed": "exec 2>&-",
                "files end at 8 kB": "ulimit -f 8", "files cannot grow": "ulimit -f 0", "20 descriptors": "ulimit -n 20", "8 descriptors": "ulimit -n 8",
                "no home": "unset HOME", "no folder for temporary files": "export TMPDIR=/nowhere", "an odd locale": "export LC_ALL=xx_YY.odd",
                "no PATH": "export PATH=/nowhere", "SIGTERM": "", "SIGINT": "", "SIGHUP": ""}
# Texts of the language and its libraries, which tell a user nothing.
not_our_words = ["terminate called", "what():", "std::", "AddressSanitizer", "runtime error:", "Assertion", "basic_string", "bad_alloc", "Could not convert", "required but"]


def commands_of(skein, words=()):
    """This command and all below it, as its help has them."""
    text = subprocess.run([skein, *words, "--help"], capture_output=True, text=True, check=True).stdout
    below, section, options, places = [], "", [], []
    for line in text.splitlines():
        if line and not line.startswith(" "):
            section = line.rstrip(":")
        elif section == "Options" and (found := re.match(r"  (?:-\w,)?(--[\w-]+)(?: (?!Needs:|Excludes:|REQUIRED)(\S+))?", line)):
            needs = re.search(r"Needs: (--\S+)", line)
            options.append(Option(found[1], found[2], needs and needs[1], " REQUIRED" in line))
        elif section == "Positionals" and (found := re.match(r"  (\w[\w-]*)", line)):
            places.append(found[1])
        elif section == "Subcommands" and (found := re.match(r"  (\w[\w-]*)", line)):
            if (*words, found[1]) not in never_run:
                below += commands_of(skein, (*words, found[1]))
    return [Command(words, options, places), *below]


def value_of(chance, option, command):
    if chance.random() < 0.06:
        return chance.choice(inputs + rubbish)
    if words := re.search(r"\{(.*?)\}", option.value):
        return chance.choice(words[1].split(","))
    if re.search(r"INT|FLOAT|^[NS]$", option.value):
        return chance.choice(numbers)
    if option.name == "--camera" and command.words[:1] == ("robots",):
        return chance.choice(values["camera"])
    return chance.choice(values.get(option.name, outputs))


def command_line(chance, commands):
    """One of a command that does something, most of the time with all that it needs."""
    command = chance.choice([c for c in commands if c.places or chance.random() < 0.1])
    words = [[chance.choice(values.get(place, inputs) if chance.random() < 0.9 else inputs)] for place in command.places]
    options = {option.name: option for option in command.options if option.name not in never_typed}
    wanted = [name for name, option in options.items() if option.required and chance.random() < 0.97]
    wanted += chance.choices(list(options), k=chance.choice([0, 1, 1, 2, 3, 5])) if options else []
    wanted += [options[name].needs for name in wanted if options[name].needs in options]
    for name in dict.fromkeys(wanted):
        words.append([name, value_of(chance, options[name], command)] if options[name].value else [name])
    chance.shuffle(words)
    return [*command.words, *(word for group in words for word in group)]


def make_folder(skein, resources, folder, environment):
    """Files of every kind, good and bad."""
    def run(*words):
        subprocess.run([skein, *words], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, check=True)

    shutil.copy(resources / "experiments/platoon.toml", folder / "e.toml")
    shutil.copy(resources / "cameras/overhead.toml", folder / "camera.toml")
    short = ("--set", "duration=1.5", "--set", "perturb=[]", "--set", "expect={}", "--quiet")
    run("run", "e.toml", *short, "--csv", "run.csv")
    run("run", "platoon-loopback", *short, "--csv", "loop.csv", "--video", "film.mkv", "--speed", "max")
    run("run", "e.toml", *short, "--keep", "--runs-dir", "runs")
    run("tags", "1-4", "--out", "tags.pdf")
    (folder / "study.toml").write_text('experiment = "e.toml"\nset = ["duration=2", "perturb=[]"]\nruns = 2\n')
    run("sweep", "study.toml", "--part", "1/2", "--into", "parts", "--quiet")
    (folder / "marks.toml").write_text("[[tag]]\nid = 1\nposition = [0, 0]\n")
    (folder / "robots.toml").write_text('[[robot]]\nname = "a"\nlink = "serial:/dev/null"\n')
    (folder / "latin.toml").write_bytes(b'name = "\xe9\xff"\n')
    (folder / "torn.csv").write_bytes((folder / "run.csv").read_bytes()[:20011])
    (folder / "torn.mkv").write_bytes((folder / "film.mkv").read_bytes()[:30000])
    (folder / "binary").write_bytes(random.Random(1).randbytes(3000))
    (folder / "empty").touch()
    (folder / "folder").mkdir()
    os.symlink("run.csv", folder / "link.csv")
    os.symlink("folder/later", folder / "dangling")
    os.symlink("circle", folder / "circle")


def contents(folder):
    found = {}
    for place, _, names in os.walk(folder):
        for path in (pathlib.Path(place) / name for name in names):
            if path.is_symlink():
                found[str(path.relative_to(folder))] = os.readlink(path)
            elif path.is_file():
                found[str(path.relative_to(folder))] = hashlib.sha1(path.read_bytes()).hexdigest()
    return found


def run_once(words, amiss, chance, folder, environment):
    """Its exit status, what it said on stderr, and whether a signal was needed: "", its name, or "nothing" that ended it."""
    shell = surroundings[amiss]
    command = ["sh", "-c", f'{shell or ":"}; exec "$@"', "sh", *words]
    # What is said goes through a pipe: a limit of files must not keep it from being read.
    process = subprocess.Popen(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               start_new_session=True)
    by = ""
    try:
        said = process.communicate(timeout=chance.uniform(0.02, 1.5) if amiss.startswith("SIG") else runs_alone)[1]
    except subprocess.TimeoutExpired:
        by = amiss if amiss.startswith("SIG") else "SIGINT"
        process.send_signal(getattr(signal, by))
        try:
            said = process.communicate(timeout=ends_within)[1]
        except subprocess.TimeoutExpired:
            by = "nothing"
            os.killpg(process.pid, signal.SIGKILL)
            said = process.communicate()[1]
    return process.returncode, said.decode(errors="replace"), by


def may_change(words):
    """Whether these words ask for something that is there to be changed."""
    return any(word in words for word in ("--force", "--save", "--repair", "remove", "forget"))


def complaints(words, amiss, status, said, by, before, after, temporary):
    if by == "nothing":
        yield "it does not end"
    elif status not in documented and not (by and status == -getattr(signal, by)):
        yield f"exit status {status}"
    if status in (2, 3) and not said.strip() and amiss != "stderr is closed":
        yield "it does not say why"
    yield from (f'it says "{text}"' for text in not_our_words if text in said)
    if "\x1b" in said:
        yield "it gives the terminal an order"
    if changed := [name for name in before if after.get(name) != before[name] and not name.endswith(".sqlite")]:
        if not may_change(words):
            yield f"it changes {changed}"
    if drafts := [name for name in after if name not in before and re.search(r"\.(part|new)(\.\d+)?$", name)]:
        yield f"it leaves {drafts}"
    if left := os.listdir(temporary):
        yield f"it leaves {left} in the folder for temporary files"


def main(program, resources):
    skein = os.path.abspath(program)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # also under nohup, which emulators heed
    first, count = int(os.environ.get("SKEIN_CHAOS_SEED", "1")), int(os.environ.get("SKEIN_CHAOS_RUNS", "8"))
    failed = 0
    with tempfile.TemporaryDirectory(prefix="skein-commands-") as place:
        root = pathlib.Path(place)
        folder, pristine, temporary = root / "x", root / "pristine", root / "tmp"
        for made in (pristine, temporary, root / "home", root / "runtime"):
            made.mkdir(mode=0o700)
        # Runs of this user must not be seen, nor stopped.
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("XDG_", "SKEIN_", "DISPLAY", "WAYLAND"))}
        environment |= {"HOME": str(root / "home"), "XDG_RUNTIME_DIR": str(root / "runtime"), "XDG_STATE_HOME": str(root / "home/state"),
                        "TMPDIR": str(temporary), "SKEIN_RUNS": "runs", "QT_QPA_PLATFORM": "offscreen"}
        commands = commands_of(skein)
        make_folder(skein, pathlib.Path(resources), pristine, environment)
        for seed in range(first, first + count):
            chance = random.Random(seed)
            shutil.copytree(pristine, folder, symlinks=True)
            os.mkfifo(folder / "fifo")
            for step in range(chance.choice([1, 1, 2, 3])):
                words, amiss = command_line(chance, commands), chance.choice(list(surroundings))
                if "aravis:nobody" in words and amiss.endswith("descriptors"):
                    continue  # Aravis 0.8 itself crashes without a socket
                before = contents(folder)
                status, said, by = run_once([skein, *words], amiss, chance, folder, environment)
                found = list(complaints(words, amiss, status, said, by, before, contents(folder), temporary))
                if found or "SKEIN_CHAOS_TELL" in os.environ:
                    typed = " ".join(repr(word) if not re.fullmatch(r"[\w./:=,+-]+", word) else word for word in words)
                    print(f"seed {seed}, step {step + 1}, {amiss}: skein {typed[:600]}\n  exit status {status}{', after ' + by if by else ''}: {said[:400]}", flush=True)
                    print("".join(f"  FAILED: {one}\n" for one in found), end="", flush=True)
                failed += bool(found)
                for left in temporary.iterdir():
                    shutil.rmtree(left, ignore_errors=True)
            shutil.rmtree(folder)
    print(f"{failed} of the command lines of {count} seeds failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
