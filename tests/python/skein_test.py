"""The package `skein`: resources/python on the path, the program in $SKEIN."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest

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


if __name__ == "__main__":
    unittest.main()
