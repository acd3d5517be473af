#!/usr/bin/python3
"""The published maneuvering models that docs/estimate.md compares with."""

import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "scripts" / "estimate"))
import published_models as models  # noqa: E402


class PublishedModels(unittest.TestCase):
    def test_a_straight_run_keeps_its_speed(self):
        for model in (models.Container(), models.Tanker()):
            with self.subTest(model.name):
                rates = model.rates((model.U, 0.0, 0.0, 0.0, 0.0), 0.0)
                self.assertAlmostEqual(rates[0], 0.0, places=6)

    def test_the_container_ship_turns_alike_to_both_sides(self):
        model = models.Container()
        starboard, port = models.turning(model), models.turning(model, -35.0)
        for index in starboard:
            self.assertAlmostEqual(starboard[index], port[index], places=6)

    def test_a_starboard_rudder_turns_to_starboard(self):
        for make in models.MODELS.values():
            model = make()
            with self.subTest(model.name):
                track = models.run(model, lambda psi, delta: 0.2, 200.0)
                self.assertGreater(track[-1][3], 0.1)
                self.assertGreater(track[-1][2], 0.0)

    def test_half_the_time_step_changes_little(self):
        model = models.Tanker()
        ends = [models.run(model, lambda psi, delta: 0.3, 300.0, dt_s)[-1] for dt_s in (0.5, 0.25)]
        self.assertLess(math.hypot(ends[0][1] - ends[1][1], ends[0][2] - ends[1][2]), 0.01 * model.L)

    def test_overshoots_of_the_container_ship_are_those_of_a_stable_one(self):
        overshoots = models.zigzag(models.Container(), 20)
        self.assertTrue(3.0 < overshoots["first"] < 12.0, overshoots)


if __name__ == "__main__":
    unittest.main()
