"""Your own controller in Python (docs/controllers.md).

    import skein.controller

    @skein.controller.law(k=(1.0, "1/s", 0, 10, "how fast errors are corrected"), logs=["distance"])
    def step(tick):
        tick.v[:] = tick.reference[:, 3] + tick.parameters["k"] * tick.error[:, 0]
        tick.omega[:] = tick.reference[:, 4] + tick.parameters["k"] * tick.error[:, 2]
        tick.log["distance"][:] = ...

    skein.controller.run(step)

With numpy every field is an array that looks into the shared memory; without it, a memoryview of doubles.
This file needs Python 3.9 and nothing else.
"""

import mmap
import os
import struct
import sys
import threading
import time

try:
    import numpy
except ImportError:  # the views are then memoryviews
    numpy = None

VERSION = 1
ROBOTS, OBSTACLES, PARAMETERS, LOGS = 64, 128, 64, 16
BYTES = 40192
MEMORY_FD, QUESTION_FD, ANSWER_FD = 3, 4, 5
WATCH_SECONDS = 0.003  # after a 'w', how long to watch for the question before sleeping again

_ROBOT, _OBSTACLE, _PARAMETER, _LOG_NAME, _COMMAND, _LOG = 256, 15616, 18688, 30464, 30976, 32000
_ROBOT_DOUBLES = 30
_FIELDS = {  # first double of a robot, how many
    "pose": (0, 3), "covariance": (3, 9), "twist": (12, 2), "nominal": (14, 5), "reference": (19, 5),
    "error": (24, 3), "limits": (27, 2), "out": (29, 1),
}


def law(logs=(), **parameters):
    """Declares what a law takes, name=(default, unit, low, high, help) or name=default, and what it logs."""

    def declare(step):
        step.skein_parameters = {
            name: given if isinstance(given, tuple) else (given, "", -1e9, 1e9, "")
            for name, given in parameters.items()
        }
        step.skein_logs = list(logs)
        return step

    return declare


class Tick:
    """What a controller sees and says; the same object every tick. SI units, world frame, robots from 0.

    pose[n, 3]: x, y, theta · covariance[n, 9] · twist[n, 2]: v, omega as driven now ·
    nominal[n, 5], reference[n, 5]: x, y, theta, v, omega · error[n, 3]: ahead, left, heading · limits[n, 2] ·
    out[n]: 1: lost or held · obstacles[m, 3]: x, y, radius · t, dt [s], tick, period [s], half_width, half_height [m] ·
    parameters: name -> number, as the operator has set them by now. To be written: v[n], omega[n], log[name][n]; they are
    NaN at the beginning of every tick, and a robot whose v or omega stays NaN stands.
    """

    def __init__(self, memory):
        self._memory = memory
        self.robots, = struct.unpack_from("<I", memory, 16)
        self.period, self.half_width, self.half_height = struct.unpack_from("<3d", memory, 24)
        self.parameters, self.log = {}, {}
        self.t = self.dt = 0.0
        self.tick = 0
        n = self.robots
        if numpy is not None:
            doubles = lambda at, count: numpy.frombuffer(memory, dtype=numpy.float64, count=count, offset=at)
            robots = doubles(_ROBOT, ROBOTS * _ROBOT_DOUBLES).reshape(ROBOTS, _ROBOT_DOUBLES)[:n]
            for name, (first, count) in _FIELDS.items():
                setattr(self, name, robots[:, first] if count == 1 else robots[:, first:first + count])
            self._obstacles = doubles(_OBSTACLE, 3 * OBSTACLES).reshape(OBSTACLES, 3)
            command = doubles(_COMMAND, 2 * ROBOTS).reshape(ROBOTS, 2)[:n]
            self._v, self._omega = command[:, 0], command[:, 1]
            self._logs = doubles(_LOG, ROBOTS * LOGS).reshape(ROBOTS, LOGS)[:n]
        else:
            view = lambda at, count: memoryview(memory)[at:at + 8 * count].cast("d")
            robots = view(_ROBOT, ROBOTS * _ROBOT_DOUBLES)
            for name, (first, count) in _FIELDS.items():
                if count == 1:
                    setattr(self, name, robots[first:n * _ROBOT_DOUBLES:_ROBOT_DOUBLES])
                else:
                    rows = [robots[i * _ROBOT_DOUBLES + first:i * _ROBOT_DOUBLES + first + count] for i in range(n)]
                    setattr(self, name, rows)
            obstacles = view(_OBSTACLE, 3 * OBSTACLES)
            self._obstacles = [obstacles[3 * k:3 * k + 3] for k in range(OBSTACLES)]
            command = view(_COMMAND, 2 * ROBOTS)
            self._v, self._omega = command[0:2 * n:2], command[1:2 * n:2]
            self._logs = view(_LOG, ROBOTS * LOGS)

    v = property(lambda self: self._v, lambda self, values: self._write(self._v, values))
    omega = property(lambda self: self._omega, lambda self, values: self._write(self._omega, values))

    def _write(self, view, values):  # tick.v = ... is tick.v[:] = ...
        if numpy is not None:
            view[:] = values
        else:
            values = list(values)
            if len(values) != self.robots:
                raise ValueError("%d numbers for %d robots" % (len(values), self.robots))
            for i, value in enumerate(values):
                view[i] = value

    @property
    def obstacles(self):
        count, = struct.unpack_from("<I", self._memory, 20)
        return self._obstacles[:count]

    def _column(self, k):
        return self._logs[:, k] if numpy is not None else self._logs[k:self.robots * LOGS:LOGS]

    def _read(self):
        self.tick, self.t, self.dt = struct.unpack_from("<qdd", self._memory, 56)


_turn = threading.Lock()
_turn.acquire()


def _fence():
    """What was read and written before comes before what is read and written after, for Skein as well. x86-64 keeps that order by itself; ARM may show
    the number of an answer before the answer. A lock that is released and taken is the only fence that Python has."""
    _turn.release()
    _turn.acquire()


def _text(text, size):
    return text.encode("utf-8", "replace")[:size - 1].ljust(size, b"\0")


def _declare(memory, step, tick):
    declared = getattr(step, "skein_parameters", None)
    logs = getattr(step, "skein_logs", [])
    if len(declared or ()) > PARAMETERS or len(logs) > LOGS:
        sys.exit("skein.controller: the law declares %d parameters and %d logs, allowed: at most %d and %d"
                 % (len(declared or ()), len(logs), PARAMETERS, LOGS))
    for name in (*(declared or ()), *logs):
        if not 0 < len(name.encode("utf-8", "replace")) < 32:
            sys.exit("skein.controller: the name %r, allowed: 1 to 31 bytes" % name)
    if declared is not None:
        for k, (name, (value, unit, low, high, text)) in enumerate(declared.items()):
            at = _PARAMETER + 184 * k
            memory[at:at + 160] = _text(name, 32) + _text(unit, 16) + _text(text, 112)
            struct.pack_into("<3d", memory, at + 160, low, high, value)
        struct.pack_into("<I", memory, 88, len(declared))
        struct.pack_into("<I", memory, 96, 1)
    for k, name in enumerate(logs):
        memory[_LOG_NAME + 32 * k:_LOG_NAME + 32 * (k + 1)] = _text(name, 32)
        tick.log[name] = tick._column(k)
    struct.pack_into("<I", memory, 92, len(logs))


def _parameter_places(memory):
    count, = struct.unpack_from("<I", memory, 88)
    places = {}
    for k in range(count):
        at = _PARAMETER + 184 * k
        places[memory[at:at + 32].split(b"\0", 1)[0].decode("utf-8", "replace")] = at + 176
    return places


def _questions(memory):
    """Their numbers, until the run is over."""
    answered = 0
    while heard := os.read(QUESTION_FD, 4096):
        question, = struct.unpack_from("<Q", memory, 48)
        if question == answered and heard.endswith(b"w"):  # a processor that is awake answers sooner
            until = time.monotonic() + WATCH_SECONDS
            while question == answered and time.monotonic() < until:
                question, = struct.unpack_from("<Q", memory, 48)
        if question != answered:
            answered = question
            _fence()
            yield question


def run(step):
    """Answers every question of the run that started this program with step(tick), until the run is over."""
    try:
        memory = mmap.mmap(MEMORY_FD, BYTES)
    except (OSError, ValueError):
        sys.exit("skein.controller: to be started by Skein: [controller] command = \"python3 ...\"")
    magic, version = struct.unpack_from("<8sI", memory, 0)
    if magic != b"skeinlaw" or version != VERSION:
        sys.exit("skein.controller: this is version %d, Skein's is %d" % (VERSION, version))
    tick = Tick(memory)
    _declare(memory, step, tick)
    os.write(ANSWER_FD, b"w")  # ready, and questions may be announced
    places = None
    for question in _questions(memory):
        tick._read()
        if places is None:
            places = _parameter_places(memory)
        for name, at in places.items():  # the operator may have changed them
            tick.parameters[name], = struct.unpack_from("<d", memory, at)
        if step(tick) is not None:
            sys.exit("skein.controller: the law returned something, which nobody reads: write tick.v[:] and tick.omega[:]")
        _fence()
        struct.pack_into("<Q", memory, 80, question)
        os.write(ANSWER_FD, b"a")
