"""The package `skein`: resources/python on the path, the program in $SKEIN."""

import contextlib
import importlib.util
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import tracemalloc
import unittest
import unittest.mock

import skein

HERE = os.path.dirname(os.path.abspath(__file__))
EXPERIMENTS = os.path.join(HERE, "..", "..", "resources", "experiments")
PLATOON = os.path.join(EXPERIMENTS, "platoon.toml")
STUDY = os.path.join(HERE, "..", "..", "resources", "studies", "kicks.toml")


def needs(module):
    found = importlib.util.find_spec(module) is not None
    return unittest.skipUnless(found, f"no {module}: install python3-{module}")


class Runs(unittest.TestCase):
    def test_summary_is_that_of_the_program(self):
        run = skein.run(PLATOON, duration=3, set={"simulation.pose_noise": 0.001}, seed=7)
        said = subprocess.run(
            [skein.program(), "run", PLATOON, "--json", "--duration", "3", "--seed", "7", "--set", "simulation.pose_noise=0.001"],
            capture_output=True,
            text=True,
        )
        self.assertEqual(run.summary, json.loads(said.stdout))
        self.assertEqual(run.ok, said.returncode == 0)
        self.assertEqual(run.summary["ticks"], 75)
        self.assertEqual(run.robots, 4)
        self.assertIn("pose_noise = 0.001", run.experiment)

    def test_a_value_of_any_kind_can_be_set(self):
        run = skein.run(
            PLATOON,
            duration=1,
            set={"name": "mine", "shield.enabled": False, "seed": 3, "controller.gains.k_xx": [[1, 2, 0.004], [2, 3, 0.002]]},
        )
        self.assertEqual(run.summary["name"], "mine")
        self.assertIn("k_xx = [[1, 2, 0.004], [2, 3, 0.002]]", run.experiment)

    def test_tables_texts_and_paths_are_set_as_what_they_are(self):
        run = skein.run(
            PLATOON,
            duration=1,
            set={"name": "7", "reference.path": {"shape": "circle", "radius": 0.45}, "expect": {}},
        )
        self.assertEqual(run.summary["name"], "7")
        self.assertIn("circle", run.experiment)
        run = skein.run(PLATOON, duration=1, set={"name": 'a "b" \\ = [1] é 🙂'})
        self.assertEqual(run.summary["name"], 'a "b" \\ = [1] é 🙂')
        for value in (None, {1, 2}, {"kind": None}):
            with self.assertRaisesRegex(skein.Error, "reference.path: .* cannot be set; allowed: numbers"):
                skein.run(PLATOON, set={"reference.path": value})
        with self.assertRaisesRegex(skein.Error, "controller.v_max"):
            skein.run(PLATOON, set={"controller.v_max": "0.08"})

    @needs("numpy")
    def test_numpys_numbers_and_arrays_can_be_set(self):
        import numpy

        gains = numpy.array([[1, 2, 0.004], [2, 3, 0.002]])
        run = skein.run(
            PLATOON,
            duration=numpy.float64(1),
            seed=numpy.int64(3),
            set={"controller.gains.k_xx": gains, "controller.v_max": numpy.float32(0.25), "shield.enabled": numpy.bool_(False)},
        )
        self.assertIn("k_xx = [[1, 2, 0.004], [2, 3, 0.002]]", run.experiment)
        self.assertIn("v_max = 0.25", run.experiment)

    def test_what_is_no_record_says_so(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(skein.Error, "is not the folder of a run that was kept"):
                skein.read(folder)
            with self.assertRaisesRegex(skein.Error, "is no row of column names: it is no record"):
                skein.read(PLATOON).columns
            picture = os.path.join(folder, "picture.png")
            with open(picture, "wb") as file:
                file.write(bytes([0x89, 0xFF, 0x00]))
            with self.assertRaisesRegex(skein.Error, "it is no record"):
                skein.read(picture).columns

    @needs("pandas")
    def test_a_torn_record_is_read_up_to_its_tear(self):
        run = skein.run(PLATOON, duration=1)
        with tempfile.TemporaryDirectory() as folder:
            torn = os.path.join(folder, "torn.csv")
            with open(run.file, "rb") as whole, open(torn, "wb") as part:
                part.write(whole.read()[:-30])
            for more in (b"", b"\0" * 512 + b"\n"):
                with open(torn, "ab") as part:
                    part.write(more)
                with contextlib.redirect_stderr(io.StringIO()) as screen:
                    self.assertEqual(list(skein.read(torn)["t"]), list(run["t"][:-1]))
                self.assertRegex(screen.getvalue(), "torn.csv: the file is torn at its end")

    @needs("pandas")
    def test_a_long_record_needs_little_more_memory_than_its_table(self):
        names = ["t", "tick", "event", "r1_x", "r1_mode", *(f"c{k}" for k in range(35))]
        rest = ",".join(f"{0.123456789 * k:.9g}" for k in range(35))
        rows = 130_000
        with tempfile.TemporaryDirectory() as folder:
            long = os.path.join(folder, "long.csv")
            with open(long, "w") as file:
                file.write("# skein\n" + ",".join(names) + "\n")
                for k in range(rows):  # r1_x is whole at first, and the events are late
                    x, event = (k, "") if k < rows / 2 else (k + 0.5, "kick")
                    file.write(f"{0.04 * k:.9g},{k},{event},{x},tracking,{rest}\n")
            tracemalloc.start()
            data = skein.read(long).data
            most = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        self.assertLess(most, 2.5 * data.memory_usage().sum())
        self.assertEqual(list(data.columns), names)
        self.assertEqual((len(data), data.index[-1], data["tick"].dtype.kind), (rows, rows - 1, "i"))
        self.assertEqual(list(data["r1_x"][[0, rows - 1]]), [0, rows - 0.5])
        self.assertEqual((data["event"].count(), data["event"][rows - 1], data["r1_mode"][0]), (rows // 2, "kick", "tracking"))

    @needs("pandas")
    def test_a_record_that_another_program_saved_is_read(self):
        run = skein.run(PLATOON, duration=1)
        with tempfile.TemporaryDirectory() as folder:
            saved = os.path.join(folder, "saved.csv")
            with open(run.file, encoding="utf-8") as lines, open(saved, "w", encoding="utf-8-sig", newline="\r\n") as other:
                other.write(lines.read())
            self.assertEqual(list(skein.read(saved)["V"]), list(run["V"]))
            self.assertEqual(skein.read(saved).experiment, run.experiment)

    def test_whatever_stands_in_a_run_json_is_read_or_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            for story in ("[]", "7", '{"x":' + "[" * 100000 + "]" * 100000 + "}"):
                with open(os.path.join(folder, "run.json"), "w") as file:
                    file.write(story)
                with self.assertRaisesRegex(skein.Error, "run.json: "):
                    skein.read(folder)
            with open(os.path.join(folder, "run.json"), "w") as file:
                file.write('{"state": "begun", "problems": 7}')
            run = skein.read(folder)
            self.assertEqual((run.summary, run.ok, run.problems), (None, None, []))

    @needs("pandas")
    def test_a_table_that_is_none_says_so(self):
        with tempfile.TemporaryDirectory() as folder:
            ragged = os.path.join(folder, "ragged.csv")
            with open(ragged, "w") as file:
                file.write("t,V\n1,2\n1,2,3,4\n")
            with self.assertRaisesRegex(skein.Error, "ragged.csv"):
                skein.read(ragged).data
            with self.assertRaisesRegex(skein.Error, "it is no record"):
                skein.read(PLATOON).data

    def test_a_program_that_is_not_there_or_another_one_is_named(self):
        for wrong, why in (
            ("/nowhere/skein", r"/nowhere/skein \(\$SKEIN\) cannot be started: No such file"),
            (HERE, "cannot be started: Permission denied"),
            ("/bin/true", "printed no summary"),
        ):
            with unittest.mock.patch.dict(os.environ, {"SKEIN": wrong}), self.assertRaisesRegex(skein.Error, why):
                skein.run(PLATOON)

    def test_what_is_refused_says_why(self):
        with self.assertRaisesRegex(skein.Error, "controller.v_max"):
            skein.run(PLATOON, set={"controller.v_max": -1})
        with self.assertRaisesRegex(skein.Error, "cannot be read"):
            skein.run("nowhere.toml")
        with self.assertRaisesRegex(skein.Error, "no such file"):
            skein.read("nowhere.csv")

    def test_an_expectation_that_fails_is_no_error(self):
        run = skein.run(PLATOON, duration=3, set={"expect.final_error": 1e-12})
        self.assertFalse(run.ok)
        self.assertRegex(run.problems[0], "final_error")

    def test_the_record_is_gone_with_the_run_unless_it_is_kept(self):
        run = skein.run(PLATOON, duration=1)
        first = run.file
        self.assertTrue(os.path.exists(first))
        with tempfile.TemporaryDirectory() as folder:
            run.save(os.path.join(folder, "run.csv"))
            self.assertFalse(os.path.exists(first))
            self.assertEqual(skein.read(run.file).columns, run.columns)

    def test_a_kept_run_is_read_by_its_folder(self):
        with tempfile.TemporaryDirectory() as runs:
            run = skein.run(PLATOON, duration=1, options=["--keep", "--runs-dir", runs])
            kept = skein.read(run.summary["kept"])
            self.assertEqual(kept.summary["ticks"], 25)
            with open(kept.file) as a, open(run.file) as b:
                self.assertEqual(a.read(), b.read())

    def test_importing_needs_nothing_and_costs_nothing(self):
        loaded = subprocess.run(
            [sys.executable, "-c", "import sys, skein; print([m for m in ('numpy', 'pandas', 'matplotlib') if m in sys.modules])"],
            capture_output=True,
            text=True,
        )
        self.assertEqual(loaded.stdout.strip(), "[]", loaded.stderr)

    @needs("pandas")
    def test_the_record_is_there_to_the_bit(self):
        run = skein.run(PLATOON, duration=3)
        self.assertEqual(len(run.data), 75)
        with open(run.file) as lines:
            rows = [line.rstrip("\n").split(",") for line in lines if not line.startswith("#")]
        for name in ("t", "V", "r3_x", "r4_omega_law", "now"):
            column = rows[0].index(name)
            self.assertEqual([float(row[column]) for row in rows[1:]], list(run[name]), name)
        self.assertEqual(run.data["r1_mode"].iloc[-1], rows[-1][rows[0].index("r1_mode")])
        self.assertEqual(run.events[0], (0.0, "start"))

    @needs("pandas")
    @needs("matplotlib")
    def test_plot_draws_every_robot(self):
        import matplotlib

        matplotlib.use("Agg")
        figure = skein.run(PLATOON, duration=2).plot()
        floor, tracking, formation = figure.axes
        self.assertEqual((len(floor.lines), len(tracking.lines), len(formation.lines)), (8, 4, 3))

    @needs("pandas")
    def test_sweep_gives_a_row_a_run(self):
        sweep = skein.sweep(STUDY, runs=3, seed=5)
        self.assertEqual(sweep.summary["runs"], 3)
        self.assertEqual(list(sweep["seed"][sweep["variant"] == "study"]), [5, 6, 7])
        self.assertEqual(list(sweep["seed"][sweep["variant"] == "control"]), [5, 6, 7])


class Ends(unittest.TestCase):
    """A run that somebody ends from Python: its robots must be told to stand."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def stand_in(self, text):
        """A program in the place of skein."""
        with open(self.path("program"), "w") as script:
            script.write("#!/bin/sh\n" + text)
        os.chmod(script.name, 0o755)
        return script.name

    def start(self):
        """Python in the middle of a run. `ended` holds the run's exit status once it has ended by itself."""
        # The signals are for the run: who waits for it ignores them.
        script = self.stand_in(f"trap '' INT TERM\n'{skein.program()}' \"$@\"\necho $? > '{self.path('ended')}'\n")
        code = f"import skein; skein.run({PLATOON!r}, csv={self.path('run.csv')!r}, options=['--speed', 'realtime'])"
        python = subprocess.Popen(
            [sys.executable, "-B", "-c", code], env={**os.environ, "SKEIN": script}, stderr=subprocess.PIPE, text=True
        )
        self.addCleanup(python.stderr.close)
        self.wait_for("run.csv")
        return python

    def wait_for(self, name):
        for _ in range(3000):
            if os.path.exists(self.path(name)) and os.path.getsize(self.path(name)):
                return
            time.sleep(0.01)
        self.fail(f"no {name} within 30 s")

    def expect_an_orderly_end(self):
        with open(self.path("ended")) as ended:
            self.assertEqual(ended.read(), "1\n")
        with open(self.path("run.csv")) as record:
            self.assertIn("stop", record.read().splitlines()[-1], "the last row of the record")

    def test_ctrl_c_waits_until_the_run_has_ended(self):
        python = self.start()
        python.send_signal(signal.SIGINT)
        self.assertIn("KeyboardInterrupt", python.communicate(timeout=60)[1])
        self.expect_an_orderly_end()

    def test_a_python_that_is_killed_leaves_no_run(self):
        python = self.start()
        python.kill()
        python.wait()
        self.wait_for("ended")
        self.expect_an_orderly_end()

    def test_what_the_program_complains_of_is_told_at_once(self):
        seen = self.path("seen")
        script = self.stand_in(
            f"echo 'skein: the camera moved' >&2\n"
            f"for k in $(seq 200); do [ -e '{seen}' ] && echo '{{}}' && exit 0; sleep 0.05; done\nexit 3\n"
        )

        class Screen(io.StringIO):
            def write(self, text):
                open(seen, "w").close()
                return super().write(text)

        with unittest.mock.patch.dict(os.environ, {"SKEIN": script}), contextlib.redirect_stderr(Screen()) as screen:
            run = skein.run(PLATOON)
        self.assertEqual(screen.getvalue(), "skein: the camera moved\n")
        self.assertEqual(run.problems, ["the camera moved"])


if __name__ == "__main__":
    unittest.main()
