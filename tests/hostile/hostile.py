"""What a terminal, a kernel, a disk or a person can do to a run; see scripts/hostile."""
import contextlib
import ctypes
import fcntl
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import termios
import time

from lab import Failed, Lab, ended_by_the_kernel, fail, wait_until

longest = 0.6   # [s]: 60 mm at 0.1 m/s
slow = dict.fromkeys(("robot-out-of-reach", "robots-stop-out-of-reach", "robots-stop-interrupted"), 5.0)  # a robot that has returned is reached anew
cases = {}      # name: (function, what it does)
PR_SET_CHILD_SUBREAPER = 36


def case(what):
    def add(function):
        cases[function.__name__.replace("_", "-")] = (function, what)
        return function
    return add


def stands(robots, seconds=30.0):
    wait_until("robots that stand", robots.all_stand, seconds)


def kill(process, what=signal.SIGKILL):
    since = time.monotonic()
    os.kill(process.pid if hasattr(process, "pid") else process, what)
    return since


def signalled(lab, what, setup=None):
    robots = lab.emulate()
    run = lab.run(robots, setup=setup)
    since = kill(run, what)
    stands(robots)
    ends(run)
    return robots.blind(since)


def state_of(pid):
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:
        return file.read().rsplit(")", 1)[1].split()[0]


def ends(process, seconds=15.0):
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        raise Failed(f"the run did not end within {seconds:g} s")


# --- The terminal -----------------------------------------------------------------------------------------------

@case("the terminal is closed (SIGHUP)")
def terminal_closed(lab):
    robots = lab.emulate()
    run = lab.run(robots, terminal=True)
    since = lab.close_terminal()
    stands(robots)
    ends(run)
    return robots.blind(since)


@case("`| tee` has ended, then SIGKILL")
def reader_gone(lab):
    robots = lab.emulate()
    reading, writing = os.pipe()
    run = lab.run(robots, stdout=writing, stderr=writing)
    os.close(writing)
    os.close(reading)
    since = kill(run)
    stands(robots)
    return robots.blind(since)


@case("2>/dev/full, then SIGKILL")
def full_device(lab):
    robots = lab.emulate()
    with open("/dev/full", "wb") as full:
        run = lab.run(robots, stdout=full, stderr=full)
    since = kill(run)
    stands(robots)
    return robots.blind(since)


@case("stdin, stdout and stderr closed, then SIGKILL")
def closed_descriptors(lab):
    robots = lab.emulate()
    run = lab.run(robots, setup=lambda: [os.close(d) for d in (0, 1, 2)])
    since = kill(run)
    stands(robots)
    return robots.blind(since)


@case("a reader that reads no more, then SIGTERM")
def reader_stalls(lab):
    robots = lab.emulate()
    reading, writing = os.pipe()
    fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, 4096)
    os.set_blocking(writing, False)
    try:
        while os.write(writing, b"x" * 512):
            pass
    except BlockingIOError:
        pass
    os.set_blocking(writing, True)
    run = lab.run(robots, stdout=writing, stderr=writing)
    since = kill(run, signal.SIGTERM)
    stands(robots)
    os.close(writing)
    os.close(reading)
    ends(run)
    return robots.blind(since)


@case("Ctrl-Z on the terminal, then continued")
def ctrl_z(lab):
    robots = lab.emulate()
    run = lab.run(robots, terminal=True)
    since = time.monotonic()
    os.write(lab.master, b"\x1a")
    stands(robots)
    wait_until("the run is suspended", lambda: state_of(run.pid) == "T")
    os.kill(run.pid, signal.SIGCONT)
    ends(run)
    return robots.blind(since)


@case("the background on a terminal with `stty tostop`")
def tostop(lab):
    robots = lab.emulate()
    shell = ("bash", "-c", 'set -m; stty tostop; "$@" & echo $! > pid; wait', "bash")
    lab.run(robots, wrap=shell, terminal=True)
    pid = int((lab.case / "pid").read_text())
    time.sleep(0.5)  # of progress on the terminal
    if state_of(pid) == "T":
        raise Failed("the run was suspended for writing")
    since = kill(pid, signal.SIGTERM)
    stands(robots)
    return robots.blind(since)


@case("Ctrl-S on the terminal, 2 s of progress, then Ctrl-C")
def ctrl_s(lab):
    robots = lab.emulate()
    run = lab.run(robots, terminal=True)
    os.write(lab.master, b"\x13")
    time.sleep(2.0)
    since = time.monotonic()
    os.write(lab.master, b"\x03")
    stands(robots)
    ends(run)
    return robots.blind(since)


# --- The process ------------------------------------------------------------------------------------------------

@case("SIGSTOP (debugger, frozen host), then continued")
def sigstop(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = kill(run, signal.SIGSTOP)
    stands(robots)
    result = robots.blind(since)
    time.sleep(1.0)
    os.kill(run.pid, signal.SIGCONT)
    if ends(run) == 0:
        raise Failed("the run went on by itself after it had stood still")
    return max(result, robots.blind(since))


@case("SIGKILL")
def sigkill(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = kill(run)
    stands(robots)
    wait_until("its marker is gone", lambda: not lab.markers())
    return robots.blind(since)


@case("SIGSEGV")
def sigsegv(lab):
    return signalled(lab, signal.SIGSEGV, lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0)))


@case("SIGINT")
def sigint(lab):
    return signalled(lab, signal.SIGINT)


@case("SIGINT, and four more in the next milliseconds")
def sigint_again(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = kill(run, signal.SIGINT)
    for _ in range(4):
        time.sleep(0.001)
        kill(run, signal.SIGINT)
    stands(robots)
    ends(run)
    if lab.markers():
        raise Failed("a run whose robots stand has left its marker")
    return robots.blind(since)


@case("SIGKILL for the run's whole process group")
def group_killed(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = time.monotonic()
    os.killpg(run.pid, signal.SIGKILL)
    stands(robots)
    return robots.blind(since)


def family_killed(lab, members):
    """Kills at once every process of the run that `members(run)` names, the run first."""
    robots = lab.emulate()
    run = lab.run(robots)
    mine = {run.pid, lab.guard_of(run)}
    since = time.monotonic()
    for pid in sorted(mine & members(run), key=lambda pid: pid != run.pid):
        os.kill(pid, signal.SIGKILL)
    if run.wait() != -signal.SIGKILL:
        raise Failed("the run itself was not killed")
    stands(robots)
    return robots.blind(since)


def named(*words):
    """What a program that looks for processes by name finds."""
    return {int(pid) for pid in subprocess.run(words, capture_output=True, text=True).stdout.split()}


@case("SIGKILL for all that is called skein (`pidof`, as `killall`)")
def all_called_skein_killed(lab):
    return family_killed(lab, lambda run: named("pidof", "skein") | named("pgrep", "skein"))


@case("SIGKILL for all whose command line has skein in it (`pkill -f`)")
def all_commands_of_skein_killed(lab):
    return family_killed(lab, lambda run: named("pgrep", "-f", "skein"))


@case("SIGKILL for the run and all its descendants (an editor's stop button)")
def process_tree_killed(lab):
    def tree(run):
        parents = lab.parents()
        found = {run.pid}
        while more := {pid for pid, parent in parents.items() if parent in found} - found:
            found |= more
        return found
    return family_killed(lab, tree)


@case("run and guard frozen for 2 s (from their waking on)")
def both_frozen(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    both = (lab.guard_of(run), run.pid)
    for pid in both:
        os.kill(pid, signal.SIGSTOP)
    time.sleep(2.0)
    if robots.all_stand():
        raise Failed("somebody else has stopped them")
    since = time.monotonic()
    for pid in reversed(both):
        with contextlib.suppress(ProcessLookupError):  # the run, awake, may have ended the guard that did not answer
            os.kill(pid, signal.SIGCONT)
    stands(robots)
    if ends(run) == 0:
        raise Failed("the run went on by itself after it had stood still")
    return robots.blind(since)


@case("the processor time that a run may use is over (`ulimit -t`: SIGKILL)")
def processor_limit(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    limited = time.monotonic()
    resource.prlimit(run.pid, resource.RLIMIT_CPU, (0, 0))
    since = ended_by_the_kernel(run, limited)  # at one of its next ticks
    if run.wait() != -signal.SIGKILL:
        raise Failed(f"the run ended by itself: {run.returncode} {lab.last_words()}")
    stands(robots)
    return robots.blind(since)


@case("it is warned that its processor time is over (`ulimit -S -t`: SIGXCPU)")
def processor_warning(lab):
    return signalled(lab, signal.SIGXCPU)


@case("the program is replaced (an upgrade), the guard killed, 1 s later the run")
def program_replaced(lab):
    installed = lab.case / "bin"
    installed.mkdir()
    for file in [lab.skein, *pathlib.Path(lab.skein).parent.glob("skein_*.so")]:
        shutil.copy(file, installed)
    robots = lab.emulate()
    run = lab.run(robots, program=installed / "skein")
    shutil.rmtree(installed)
    first = lab.guard_of(run)
    kill(first)
    time.sleep(1.0)
    if lab.guard_of(run) in (None, first):
        raise Failed("there is no new guard after 1 s: " + lab.last_words())
    since = kill(run)
    stands(robots)
    return robots.blind(since)


def quits(lab, disposition):
    def set_up():
        signal.signal(signal.SIGQUIT, disposition)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    return signalled(lab, signal.SIGQUIT, set_up)


@case("SIGQUIT (Ctrl-\\)")
def sigquit(lab):
    return quits(lab, signal.SIG_DFL)


@case("likewise, started with SIGQUIT ignored (in the background of a script)")
def sigquit_ignored(lab):
    return quits(lab, signal.SIG_IGN)


@contextlib.contextmanager
def busy():
    """Four processes without end for every processor."""
    spinners = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(4 * os.cpu_count())]
    try:
        yield
    finally:
        for spinner in spinners:
            spinner.kill()
            spinner.wait()


def goes_on(lab, run, seconds):
    """The run is not stopped falsely meanwhile."""
    end = time.monotonic() + seconds
    while time.monotonic() < end and run.poll() is None:
        time.sleep(0.05)
    for sentence in ("has stalled", "the guard is frozen", "STOP", "stood still"):
        if sentence in lab.log():
            raise Failed("stopped falsely: " + lab.last_words())
    if run.poll() is not None:
        raise Failed("the run ended: " + lab.last_words())


def without_real_time():
    """As a user to whom nobody has granted priorities."""
    PR_CAPBSET_DROP, CAP_SYS_NICE = 24, 23
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_SYS_NICE)
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))


def busy_then_interrupted(lab, setup=None):
    robots = lab.emulate()
    run = lab.run(robots, setup=setup)
    with busy():
        goes_on(lab, run, 6.0)
        if robots.all_stand():
            raise Failed("they stand: " + lab.last_words())
        since = kill(run, signal.SIGINT)
        stands(robots)
    ends(run)
    return robots.blind(since)


@case("all processors busy for 6 s: nobody is stopped falsely; then SIGINT")
def busy_machine(lab):
    return busy_then_interrupted(lab)


@case("likewise, without real-time priorities")
def busy_machine_no_real_time(lab):
    return busy_then_interrupted(lab, without_real_time)


def threads_stopped(lab, priority):
    """A debugger stops the run's threads of this priority alone, and lets them go on 1 s later."""
    SEIZE, INTERRUPT, DETACH, WALL = 0x4206, 0x4207, 17, 0x40000000
    ptrace = ctypes.CDLL(None).ptrace
    ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    robots = lab.emulate()
    run = lab.run(robots)
    tasks = [int(task) for task in os.listdir(f"/proc/{run.pid}/task")]
    tasks = [task for task in tasks if os.sched_getparam(task).sched_priority == priority]
    if not tasks or any(ptrace(SEIZE, task, None, None) != 0 for task in tasks):
        return None  # no priorities are granted here, or nobody may trace
    since = time.monotonic()
    for task in tasks:
        ptrace(INTERRUPT, task, None, None)
        os.waitpid(task, WALL)
    stands(robots)
    result = robots.blind(since)
    time.sleep(max(0.0, since + 1.0 - time.monotonic()))
    for task in tasks:
        ptrace(DETACH, task, None, None)
    if ends(run) == 0:
        raise Failed("the run went on by itself after a thread had stood still")
    return max(result, robots.blind(since))


@case("the control thread alone gets no time for 1 s (a debugger stops it)")
def control_thread_stopped(lab):
    return threads_stopped(lab, 20)


@case("the link thread alone gets no time for 1 s")
def link_thread_stopped(lab):
    return threads_stopped(lab, 21)


# --- What runs out ----------------------------------------------------------------------------------------------

@case("no more file descriptors (pictures are files too), then a link is lost")
def descriptor_limit(lab):
    robots = lab.emulate(faults='[[fault]]\nkind = "disconnect"\nrobot = 2\nat = 8.0\nfor = 3.0\n')
    run = lab.run(robots)
    resource.prlimit(run.pid, resource.RLIMIT_NOFILE, (3, 3))
    wait_until("the line of robot 2 hangs up", lambda: time.monotonic() > robots.offset + 8.0)
    wait_until("robot 1 stands since robot 2 is lost", lambda: not robots.drives(1), 20.0)
    ends(run)
    stands(robots)
    return robots.blind(robots.offset + 8.0, whose=[1])


@case("no more file descriptors, the guard killed, then SIGINT")
def descriptor_limit_guard(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    guard = lab.guard_of(run)
    # Without descriptors no picture can be read either: the run may end for that before it misses its guard.
    resource.prlimit(run.pid, resource.RLIMIT_NOFILE, (3, 3))
    kill(guard)
    wait_until("the operator is told that there is no guard, or the run has ended",
               lambda: "no guard" in lab.log() or run.poll() is not None, 5.0)
    since = kill(run, signal.SIGINT) if run.poll() is None else time.monotonic()
    stands(robots)
    ends(run)
    return robots.blind(since)


@case("no more memory, 3 s later SIGINT")
def memory_limit(lab):
    robots = lab.emulate()
    run = lab.run(robots, "--csv", lab.case / "run.csv")
    resource.prlimit(run.pid, resource.RLIMIT_AS, (1, 1))
    resource.prlimit(run.pid, resource.RLIMIT_DATA, (1, 1))
    since = time.monotonic()
    time.sleep(3.0)
    if run.poll() is None and not robots.all_stand():
        since = kill(run, signal.SIGINT)
    stands(robots)
    ends(run)
    return robots.blind(since)


@case("the state directory cannot be written, then SIGKILL")
def no_state_directory(lab):
    lab.environment["XDG_STATE_HOME"] = "/proc/nowhere"
    robots = lab.emulate()
    run = lab.run(robots)
    lab.hears("/proc/nowhere/skein")
    since = kill(run)
    stands(robots)
    return robots.blind(since)


@case("the state directory is removed in the middle, then SIGKILL")
def state_directory_removed(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    shutil.rmtree(lab.case / "state")
    since = kill(run)
    stands(robots)
    return robots.blind(since)


def kept_awake(lab):
    """A logind, robots that drive, their run, which keeps the machine awake; None: there is no dbus-daemon."""
    logind = lab.logind()
    if logind is None:
        return None
    robots = lab.emulate()
    run = lab.run(robots)
    wait_until("the machine is kept awake", lambda: logind.inhibitors == 1, 5.0)
    return logind, robots, run


@case("the machine would go to sleep: held awake as long as robots drive")
def sleep_inhibited(lab):
    if (awake := kept_awake(lab)) is None:
        return None
    logind, robots, run = awake
    since = kill(run, signal.SIGINT)
    stands(robots)
    ends(run)
    wait_until("the machine may sleep again", lambda: logind.inhibitors == 0, 5.0)
    return robots.blind(since)


@case("the machine is shut down: that waits until the robots stand")
def shut_down(lab):
    if (awake := kept_awake(lab)) is None:
        return None
    logind, robots, run = awake
    since = time.monotonic()
    logind.shut_down()
    wait_until("the machine is shut down", lambda: logind.down, 5.0)
    if not robots.all_stand():
        raise Failed("the machine is shut down while robots drive")
    lab.hears("STOP: this machine is about to be shut down")
    ends(run)
    return robots.blind(since)


@case("sleep is still inhibited for a robot that does not acknowledge its stop")
def sleep_inhibited_longer(lab):
    logind = lab.logind()
    if logind is None:
        return None
    robots = lab.emulate(faults='[[fault]]\nkind = "burst"\nrobot = 2\nat = 8.0\nfor = 4.0\n')
    run = lab.run(robots)
    wait_until("robot 2 is out of reach", lambda: time.monotonic() > robots.offset + 8.0)
    wait_until("robot 1 stands since robot 2 is lost", lambda: not robots.drives(1), 20.0)
    time.sleep(0.5)
    if run.poll() is None and robots.drives(2) and logind.inhibitors != 1:
        raise Failed("the machine may sleep while a robot drives")
    ends(run)
    stands(robots)
    return robots.blind(robots.offset + 8.0, whose=[1])


@case("started with every signal blocked, then SIGTERM")
def blocked_signals(lab):
    return signalled(lab, signal.SIGTERM,
                     lambda: signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals()))


@case("started with SIGINT and SIGTERM ignored (`trap '' INT TERM`), then SIGTERM")
def ignored_signals(lab):
    def ignore():
        for what in (signal.SIGINT, signal.SIGTERM, signal.SIGCHLD, signal.SIGPIPE):
            signal.signal(what, signal.SIG_IGN)

    return signalled(lab, signal.SIGTERM, ignore)


@case("a signal that nobody expects (SIGUSR1)")
def unexpected_signal(lab):
    return signalled(lab, signal.SIGUSR1)


# --- The guard --------------------------------------------------------------------------------------------------

@case("the guard is killed, 1 s later the run")
def guard_killed(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    first = lab.guard_of(run)
    if first is None:
        raise Failed("there is no guard")
    kill(first)
    time.sleep(1.0)
    if lab.guard_of(run) in (None, first):
        raise Failed("there is no new guard after 1 s")
    lab.hears("the guard has died")
    since = kill(run)
    stands(robots)
    return robots.blind(since)


@case("the guard is frozen, 2 s later the run killed")
def guard_frozen(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    first = lab.guard_of(run)
    kill(first, signal.SIGSTOP)
    time.sleep(2.0)
    if lab.guard_of(run) == first:
        raise Failed("a frozen guard is still the only one")
    since = kill(run)
    stands(robots)
    return robots.blind(since)


def killed_out_of_reach(lab, away):
    """The run is killed while its robot 1 cannot be reached for so long. The robots, the run, and when the robot is back."""
    at = 8.0
    robots = lab.emulate(faults=f'[[fault]]\nkind = "burst"\nrobot = 1\nat = {at}\nfor = {away}\n')
    run = lab.run(robots)
    wait_until("the robot is out of reach", lambda: time.monotonic() > robots.offset + at + 0.05)
    kill(run)
    return robots, run, robots.offset + at + away


def blind_since_return(robots, back):
    seconds, way = robots.blind(back, whose=[1])
    return (max(0.0, seconds), way)


@case("killed while a robot cannot be reached for 20 s (from its return on)")
def robot_out_of_reach(lab):
    away = 20.0
    robots, _, back = killed_out_of_reach(lab, away)
    # It is asked again and again: 2 s of one attempt and what a new connection takes.
    stands(robots, away + 20.0)
    return blind_since_return(robots, back)


# --- The disk ---------------------------------------------------------------------------------------------------

def stalled(lab, robots, size=4096):
    fifo = lab.case / "run.csv"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    fcntl.fcntl(reader, fcntl.F_SETPIPE_SZ, size)
    return fifo, reader


@case("the CSV's disk stalls and a link is lost")
def stalled_disk_lost_link(lab):
    robots = lab.emulate(faults='[[fault]]\nkind = "burst"\nrobot = 2\nat = 8.0\nfor = 3.0\n')
    fifo, reader = stalled(lab, robots)
    run = lab.run(robots, "--csv", fifo)
    wait_until("robot 1 stands since robot 2 is lost", lambda: not robots.drives(1), 20.0)
    ends(run)
    os.close(reader)
    # The link counts as lost `link_bridge` after its last sign of life: 0.3 s in this experiment.
    return robots.blind(robots.offset + 8.0, whose=[1])


@case("the CSV's disk stalls, then SIGINT")
def stalled_disk_sigint(lab):
    robots = lab.emulate()
    fifo, reader = stalled(lab, robots)
    run = lab.run(robots, "--csv", fifo)
    time.sleep(1.0)
    since = kill(run, signal.SIGINT)
    stands(robots)
    ends(run, 12.0)
    os.close(reader)
    lab.hears("NOT written")
    return robots.blind(since)


@case("the CSV grows beyond `ulimit -f`")
def file_limit(lab):
    robots = lab.emulate()
    limit, csv = 100_000, lab.case / "run.csv"
    run = lab.run(robots, "--csv", csv, setup=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    wait_until("the file is full", lambda: csv.stat().st_size >= limit)
    since = time.monotonic()
    stands(robots)
    if ends(run) != 3:
        raise Failed("a record that cannot be kept is exit status 3")
    return robots.blind(since)


# --- STOP from outside ------------------------------------------------------------------------------------------

@case("skein stop")
def skein_stop(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = time.monotonic()
    status, said = lab.skein_says("stop")
    stands(robots)
    ends(run)
    if status != 0 or said.count("stopped") < 2:
        raise Failed(said)
    return robots.blind(since)


def skein_stop_limited(lab, limit, value):
    """The exit status of `skein stop` under a limit, with a log for its output, and what it said."""
    with open(lab.case / "log", "w") as log:
        status = subprocess.run([lab.skein, "stop"], cwd=lab.case, env=lab.environment, stdin=subprocess.DEVNULL, stdout=log,
                                stderr=log, timeout=30.0, preexec_fn=lambda: resource.setrlimit(limit, (value, value))).returncode
    return status, (lab.case / "log").read_text()


@case("skein stop into a log that has grown to its `ulimit -f`")
def skein_stop_full_log(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = time.monotonic()
    status, _ = skein_stop_limited(lab, resource.RLIMIT_FSIZE, 0)
    stands(robots)
    ends(run)
    if status < 0:
        raise Failed(f"signal {-status} ended it")
    return robots.blind(since)


@case("skein stop with `ulimit -n 4` (which finds no run), then without")
def skein_stop_descriptors(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    status, said = skein_stop_limited(lab, resource.RLIMIT_NOFILE, 4)
    if status != 3 or "Too many open files" not in said or "no run" in said:
        raise Failed(f"exit status {status}: {said}")
    since = time.monotonic()
    lab.skein_says("stop")
    stands(robots)
    ends(run)
    return robots.blind(since)


@case("skein robots stop while a run drives")
def robots_stop_running(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = time.monotonic()
    status, said = lab.skein_says("robots", "stop")
    stands(robots)
    ends(run)
    if status != 0 or said.count(": stopped") != 2:
        raise Failed(said)
    return robots.blind(since)


@case("skein robots stop while the run is frozen (from the freeze on)")
def robots_stop_frozen(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    since = kill(run, signal.SIGSTOP)
    status, said = lab.skein_says("robots", "stop")
    stands(robots)
    ends(run)
    if status != 0 or said.count(": stopped") != 2:
        raise Failed(said)
    return robots.blind(since)


@case("skein robots stop while run and guard are frozen (from when it is called)")
def robots_stop_both_frozen(lab):
    robots = lab.emulate()
    run = lab.run(robots)
    for pid in (lab.guard_of(run), run.pid):
        os.kill(pid, signal.SIGSTOP)
    time.sleep(0.5)
    if robots.all_stand():
        raise Failed("somebody else has stopped them")
    since = time.monotonic()
    status, said = lab.skein_says("robots", "stop")
    stands(robots)
    if status != 0 or said.count(": stopped") != 2:
        raise Failed(said)
    return robots.blind(since)


@case("killed while a robot cannot be reached for 9 s, then skein robots stop (from its return on)")
def robots_stop_out_of_reach(lab):
    robots, run, back = killed_out_of_reach(lab, away=9.0)
    run.wait()
    status, said = lab.skein_says("robots", "stop", seconds=60.0)
    if status != 0 or said.count(": stopped") != 2:
        raise Failed(f"exit status {status}: {said}")
    stands(robots)
    return blind_since_return(robots, back)


@case("likewise, out of reach for 12 s: skein robots stop ends at Ctrl-C alone, the guard goes on")
def robots_stop_interrupted(lab):
    robots, run, back = killed_out_of_reach(lab, away=12.0)
    run.wait()
    stop = subprocess.Popen([lab.skein, "robots", "stop"], cwd=lab.case, env=lab.environment, text=True, stdin=subprocess.DEVNULL,
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = ""
    while "still trying" not in said:
        said += stop.stderr.readline()
    stop.send_signal(signal.SIGHUP)
    time.sleep(0.5)
    if stop.poll() is not None:
        raise Failed("it ends with its terminal")
    stop.send_signal(signal.SIGINT)
    said += stop.communicate(timeout=4.0)[1]
    if stop.returncode != 3 or "NOT known to be stopped" not in said:
        raise Failed(f"exit status {stop.returncode}: {said}")
    stands(robots)
    return blind_since_return(robots, back)


def orphans(lab):
    """Robots that drive and that nobody holds: guard and run are killed."""
    robots = lab.emulate()
    run = lab.run(robots)
    kill(run, signal.SIGSTOP)  # nobody starts a new guard
    kill(lab.guard_of(run))
    kill(run)
    run.wait()
    if robots.all_stand():
        raise Failed("nothing is left to be stopped")
    return robots


@case("run and guard killed, then skein robots stop")
def both_killed(lab):
    robots = orphans(lab)
    since = time.monotonic()
    status, said = lab.skein_says("robots", "stop")
    stands(robots)
    if status != 0:
        raise Failed(said)
    return robots.blind(since)


@case("robots stop ADDRESS with a broken robots.toml")
def broken_robots_file(lab):
    robots = orphans(lab)
    (lab.case / "robots.toml").write_text('[[robot]\nname = "a"\nlink = "serial:/dev/nothing"\n')
    since = time.monotonic()
    for robot in (1, 2):
        status, said = lab.skein_says("robots", "stop", robots.address(robot))
        if status != 0:
            raise Failed(said)
    stands(robots)
    return robots.blind(since)


@case("robots stop FILE with a mistake in [avoidance]")
def broken_experiment(lab):
    robots = orphans(lab)
    path = lab.experiment(robots, "mistaken.toml")
    path.write_text(path.read_text() + "\n[avoidance]\nenabled = 7\n")
    since = time.monotonic()
    _, said = lab.skein_says("robots", "stop", path)
    stands(robots)
    if "avoidance" not in said:
        raise Failed("the mistake was not told: " + said)
    return robots.blind(since)


def alive(marker):
    """Whether the run that wrote this marker still holds its lock."""
    try:
        with open(marker) as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except BlockingIOError:
        return True
    return False


@case("two runs of the same process number (PID namespaces), then robots stop")
def same_process_number(lab):
    wrap = ("unshare", "--user", "--map-current-user", "--pid", "--fork", "--mount-proc", "--kill-child")
    if subprocess.run([*wrap, "true"], capture_output=True).returncode != 0:
        return None
    groups = [lab.emulate(name="one"), lab.emulate(name="two")]
    for robots in groups:
        run = lab.run(robots, wrap=wrap)
        os.kill(run.pid, signal.SIGKILL)  # the whole namespace goes with it, its guard as well
        run.wait()
    # A namespace takes a moment to go: its guard may still stop its robots and remove the marker, and a run that is just
    # dying is asked first. What is measured is two runs that are gone.
    wait_until("the runs are gone", lambda: not any(alive(marker) for marker in lab.markers()), 10)
    left = len(lab.markers())
    since = time.monotonic()
    _, said = lab.skein_says("robots", "stop")
    for robots in groups:
        stands(robots)
    if said.count(": stopped") != 2 * left:
        raise Failed(f"{left} markers of 2 runs: {said}")
    return max(robots.blind(since) for robots in groups)


def main(skein, pictures, logind, wanted):
    unknown = [word for word in wanted if word not in cases]
    if unknown:
        fail(f"hostile: no case {unknown[0]}; allowed: {' '.join(cases)}")
        return 2
    lab = Lab(os.path.abspath(skein), os.path.abspath(pictures), os.path.abspath(logind))
    began = time.monotonic()
    print(f"{'case':<24} {'what is done':<74} {'blind s':>8} {'way mm':>7} {'at 0.1 m/s':>10}", flush=True)
    failed = driving = skipped = 0
    worst = 0.0
    # A run may start another before it ends: whoever is left behind is ours to wait for.
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    for name, (function, what) in cases.items():
        if wanted and name not in wanted:
            continue
        lab.start_case()
        problem, result = "", None
        try:
            result = function(lab)
        except (Failed, OSError, subprocess.SubprocessError) as error:
            problem = str(error)
        left = sum(robots.drives(i + 1) for robots in lab.robots for i in range(robots.count))
        log = lab.last_words()
        lab.end_case()
        if result is None and not problem:
            print(f"{name:<24} {what:<74} {'skipped':>8}", flush=True)
            skipped += 1
            continue
        if problem:
            result = (float("nan"), float("nan"))
        seconds, way = result
        allowed = slow.get(name, longest)
        late = not problem and seconds > allowed
        print(f"{name:<24} {what:<74} {seconds:8.3f} {1e3 * way:7.1f} {100 * seconds:7.0f} mm"
              f"{'  TOO LATE' if late else ''}{'  FAILED' if problem else ''}", flush=True)
        if problem or late:
            failed += 1
            fail(f"  {problem or 'too late'}\n  log: {log}")
        elif name not in slow:
            worst = max(worst, seconds)
        driving += left
    print(f"worst {worst:.3f} s, {100 * worst:.0f} mm at 0.1 m/s; {driving} robots left driving; {failed} failed, "
          f"{skipped} skipped; {time.monotonic() - began:.0f} s", flush=True)
    return 1 if failed or driving else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]))
