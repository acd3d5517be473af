"""A few hundred command lines and faults of the campaign, and that it sees what it looks for."""

import pathlib
import random
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts" / "reliability"
sys.path.insert(0, str(SCRIPTS))
import command_lines  # noqa: E402
import workspace  # noqa: E402
import writers  # noqa: E402


class ReliabilityTest(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory(prefix="leeway-reliability-")
        self.folder = pathlib.Path(self.temporary.name) / "work"
        self.addCleanup(self.temporary.cleanup)

    def test_no_mutated_command_line_fails(self):
        campaign = command_lines.Campaign(self.folder, 1)
        for _ in range(300):
            campaign.step()
        self.assertEqual(campaign.failures, [])
        for code in (0, 2, 3, 4):
            self.assertGreater(campaign.counts[f"exit code {code}"], 0)

    def test_broken_files_are_known_as_such(self):
        for name, text in (("a.json", b'{"a": 1'), ("a.json", b"\xff"), ("a.csv", b"t_s,u\n1\n"), ("a.csv", b"")):
            self.assertTrue(command_lines.is_broken(name, text), (name, text))
        for name, text in (("a.json", b"[1]"), ("a.csv", b"t_s,u\n1,2\n")):
            self.assertFalse(command_lines.is_broken(name, text), (name, text))

    def test_results_that_are_cut_off_are_known_as_such(self):
        for name, text in (("a.json", b'{"a": NaN}'), ("a.csv", b"t_s,u\n1,2"), ("a.csv", b"t_s,u\n1,inf\n")):
            self.assertNotEqual(command_lines.problem_of_result(name, text), "", (name, text))
        self.assertEqual(command_lines.problem_of_result("a.csv", b"t_s,u\n1,-2e-3\n"), "")

    def test_torn_and_mixed_outputs_are_known_as_such(self):
        first, second = {"d/x": b"1", "d/y": b"1", "d/i": b"1"}, {"d/x": b"2", "d/i": b"2"}

        def problem(**files):
            return writers.problem_of({f"d/{name}": text for name, text in files.items()}, "d/i", first, second)

        self.assertEqual(problem(x=b"1", y=b"1", i=b"1"), "")
        self.assertEqual(problem(x=b"2", y=b"1"), "")  # no index: nothing says that they belong together
        self.assertEqual(problem(), "")
        self.assertIn("torn", problem(x=b"half"))
        self.assertIn("mixed", problem(x=b"2", y=b"1", i=b"1"))
        self.assertIn("mixed", problem(x=b"1", i=b"1"))

    def test_mutations_change_something(self):
        rng = random.Random(1)
        text = b'{"a": [1, 2, {"b": 3}]}'
        self.assertGreater(len({command_lines.mutate_file("a.json", text, rng) for _ in range(200)}), 30)

    def test_every_writer_writes_again_what_it_wrote(self):
        workspace.prepare(self.folder)
        (self.folder / "out").mkdir()
        for name in ("data set", "recording", "metrics"):
            writer = writers.Writer(name, self.folder)
            writer.put(writer.other)
            self.assertEqual(writer.problem_after_rerun(), "")


if __name__ == "__main__":
    unittest.main()
