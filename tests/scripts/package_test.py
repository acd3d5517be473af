#!/usr/bin/python3
"""Makes the package for Debian, installs it into an empty root, and works from there: files and owners, dependencies, no
path of the build, the pipeline, man pages, completion. Ends with 77, and says why, where a package cannot be made."""

import gzip
import json
import os
import pathlib
import pty
import re
import select
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("LEEWAY_BIN", ROOT / "build" / "release" / "bin")).resolve()
BUILD = BIN.parent
TOOLS = sorted(app.stem for app in (ROOT / "apps").glob("*.cpp"))
NEEDED = ("cpack", "dpkg", "dpkg-deb", "dpkg-shlibdeps", "file", "help2man", "readelf")
SKIPPED = 77
# README's pipeline and its look into a simulator, small.
CONFIG = '{"hidden_units": 8, "steps": 20, "initial_state_steps": 5, "batch_size": 16, "learning_rate": 1e-3, "epochs": 2}'
PIPELINE = f"""
mmg-sim dataset demo -o data
echo '{CONFIG}' > small.json
ens-train 'data/dataset.json#Train' --config small.json --members 3 --base vectwin-3m-estimated -o model
ens-predict model 'data/dataset.json#Test-ZT' --particles 6 -o - | eval-metrics - --truth 'data/dataset.json#Test-ZT' -o metrics.json
pd-sweep model --ship vectwin-3m --kp 20 --kd 20:40:20 --particles 6 -o sweep.csv
mmg-sim zigzag --ship esso-osaka-3m --noise paper-model-scale --duration-s 100 -o zigzag.csv
gap-locate --ship esso-osaka-3m zigzag.csv -o gap
gap-explain --ship esso-osaka-3m zigzag.csv -o explained
leeway-bench sim
"""


def output_of(*command, **options) -> str:
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True, **options).stdout


class PackageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="leeway-package-")
        cls.addClassCleanup(temporary.cleanup)
        cls.work = pathlib.Path(temporary.name)
        # gzip takes seconds where xz, which compresses the package else, takes half a minute
        output_of("cpack", "--config", BUILD / "CPackConfig.cmake", "-G", "DEB", "-B", cls.work, "-D",
                  "CPACK_LEEWAY_COMPRESSION=-Zgzip;-z1", cwd=cls.work)
        [cls.package] = cls.work.glob("*.deb")
        cls.root = cls.work / "root"
        for folder in ("updates", "info", "parts"):
            (cls.root / "var/lib/dpkg" / folder).mkdir(parents=True)
        (cls.root / "var/lib/dpkg/status").touch()
        # By dpkg itself, also by an ordinary user. What the package depends on is not in that root: it is not configured.
        cls.dpkg("--unpack", cls.package)
        cls.environment = {"PATH": f"{cls.root}/usr/bin:/usr/bin:/bin", "HOME": str(cls.work), "LC_ALL": "C.UTF-8"}

    @classmethod
    def dpkg(cls, *command):
        path = f"{os.environ['PATH']}:/usr/local/sbin:/usr/sbin:/sbin"  # dpkg looks for ldconfig
        return output_of("dpkg", f"--root={cls.root}", "--force-not-root", "--log=/dev/null", *command, env={**os.environ, "PATH": path})

    def field(self, name: str) -> str:
        return output_of("dpkg-deb", "--field", self.package, name).strip()

    def installed(self) -> list[pathlib.Path]:
        return sorted(path for path in (self.root / "usr").rglob("*") if path.is_file())

    def test_the_files_are_where_debian_wants_them_and_belong_to_root(self):
        version = re.search(r"project\(leeway VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
        self.assertEqual(self.package.name, f"leeway_{version}_{output_of('dpkg', '--print-architecture').strip()}.deb")
        rows = [row.split(maxsplit=5) for row in output_of("dpkg-deb", "--contents", self.package).splitlines()]
        self.assertEqual({row[1] for row in rows}, {"root/root"})
        self.assertEqual(sorted(path.name for path in (self.root / "var/lib/dpkg/info").iterdir()),
                         ["format", "leeway.list", "leeway.md5sums"])  # no scripts that run at the installation
        modes = {row[5].split(" -> ")[0]: row[0] for row in rows}
        for path, mode in modes.items():
            kind, is_program = mode[0], path.startswith("./usr/bin/") and path != "./usr/bin/"
            expected = "lrwxrwxrwx" if kind == "l" else "drwxr-xr-x" if kind == "d" else f"-rw{'xr-xr-x' if is_program else '-r--r--'}"
            self.assertEqual(mode, expected, path)
        share = self.root / "usr/share"
        self.assertEqual(sorted(path.name for path in (self.root / "usr/bin").iterdir()), TOOLS)
        for tool in TOOLS:
            self.assertTrue((share / f"man/man1/{tool}.1.gz").is_file(), tool)
            self.assertTrue((share / f"bash-completion/completions/{tool}").is_file(), tool)
        for name in ("README.md", "CHANGELOG.md", "copyright", "docs/mmg-sim.md"):
            self.assertTrue((share / "doc/leeway" / name).is_file(), name)
        configs = {path.relative_to(ROOT): path.read_bytes() for path in (ROOT / "configs").rglob("*.json")}
        shipped = {path.relative_to(share / "leeway"): path.read_bytes() for path in (share / "leeway").rglob("*.json")}
        self.assertEqual(shipped, configs)

    def test_the_changelog_is_in_debian_s_format(self):
        text = gzip.decompress((self.root / "usr/share/doc/leeway/changelog.gz").read_bytes()).decode()
        self.assertTrue(text.startswith(f"leeway ({self.field('Version')}) unstable; "), text[:60])
        self.assertIn(f" -- {self.field('Maintainer')}  ", text)
        plain = self.work / "changelog"
        plain.write_text(text)
        parsed = subprocess.run(["dpkg-parsechangelog", "-l", plain], check=True, capture_output=True, text=True)
        self.assertEqual(parsed.stderr, "")  # its warnings
        for point in re.findall(r"^- (\S+ \S+ \S+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE):
            self.assertIn(f"  * {point}", text)

    def test_it_depends_on_the_libraries_of_the_tools_and_of_what_they_load(self):
        names = self.field("Depends")
        for library in ("libfmt", "libssl", "libcholmod", "liblapack"):  # the last two are those of minimizer.so
            self.assertIn(library, names)
        # On this machine, where leeway is built, all is there: apt would install leeway and nothing else.
        plan = output_of("apt-get", "--simulate", "install", self.package, env={**os.environ, "LC_ALL": "C.UTF-8"})
        self.assertEqual(re.findall(r"^Inst (\S+)", plan, re.MULTILINE), ["leeway"])

    def test_nothing_in_it_names_a_folder_of_the_build(self):
        for path in self.installed():
            data = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
            for folder in (ROOT, BUILD, self.work):
                self.assertNotIn(bytes(folder), data, path)
            if data.startswith(b"\x7fELF"):
                self.assertNotRegex(output_of("readelf", "-d", path), r"RPATH|RUNPATH")
                self.assertNotIn(".symtab", output_of("readelf", "-SW", path))

    def test_the_pipeline_runs_from_the_installed_folder(self):
        folder = self.work / "pipeline"
        folder.mkdir()
        for tool in TOOLS:
            self.assertEqual(output_of("sh", "-c", f"command -v {tool}", env=self.environment).strip(),
                             str(self.root / "usr/bin" / tool))
        run = subprocess.run(["bash", "-euo", "pipefail", "-c", PIPELINE], cwd=folder, capture_output=True, text=True,
                             env={**self.environment, "LD_DEBUG": "files", "LD_DEBUG_OUTPUT": str(self.work / "loaded")}, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn('"bench":"sim"', run.stdout)
        for name in ("metrics.json", "gap/locate.json", "explained/report.json", "explained/ship.json"):
            text = (folder / name).read_text()
            self.assertNotIn(str(ROOT), text, name)
            json.loads(text)
        inputs = json.loads((folder / "explained/report.json").read_text())["provenance"]["inputs"]
        self.assertIn("configs/ships/esso-osaka-3m.json", [entry["file"] for entry in inputs])
        loaded = "".join(path.read_text() for path in self.work.glob("loaded.*"))
        self.assertIn(f"calling init: {self.root}/usr/lib/leeway/minimizer.so", loaded)
        self.assertNotIn(str(BUILD), loaded)

    @unittest.skipIf(shutil.which("man") is None, "man is not installed")
    def test_man_pages_render_and_hold_all_that_help_says(self):
        pages = sorted((self.root / "usr/share/man/man1").iterdir())
        commands = output_of(BIN / "mmg-sim", "--complete", "").split()[1:]
        self.assertEqual([page.name for page in pages],
                         sorted(f"{name}.1.gz" for name in [*TOOLS, *(f"mmg-sim-{command}" for command in commands)]))
        known = output_of("lexgrog", *pages)  # what apropos and whatis read
        for page in pages:
            name = page.name.removesuffix(".1.gz")
            self.assertIn(f'"{name} - ', known)
            words = ["mmg-sim", name.removeprefix("mmg-sim-")] if name.startswith("mmg-sim-") else [name]
            source = re.sub(r"\\f[BRI]", "", gzip.decompress(page.read_bytes()).decode().replace("\\-", "-"))
            for option in re.findall(r"^  (\S*--\S+)", output_of(BIN / words[0], *words[1:], "--help"), re.MULTILINE):
                self.assertIn(f".TP\n{option}", source, name)
        environment = {**os.environ, "LC_ALL": "C.UTF-8", "MANWIDTH": "80"}
        for words in (["gap-explain"], ["mmg-sim", "zigzag"]):
            text = output_of("man", "--manpath", self.root / "usr/share/man", *words, env=environment)
            self.assertRegex(text, rf"(?s)^{'-'.join(words).upper()}\(1\).*\n *--ship TEXT REQUIRED\n.*\nSEE ALSO\n")
            checked = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", "-Z",
                                      self.root / f"usr/share/man/man1/{'-'.join(words)}.1.gz"],
                                     check=True, capture_output=True, text=True, env=environment)
            self.assertEqual(checked.stderr, "", words)  # the formatter's warnings

    def completed(self, line: str) -> list[str]:
        """What bash offers for the last word of a line: those that bash takes it apart to, through the installed file."""
        words = re.findall(r"=|[^\s=]+|(?<=\s)$", line)
        current = "" if words[-1] == "=" else words[-1]
        script = (f"source {shlex.quote(str(self.root / 'usr/share/bash-completion/completions' / words[0]))}\n"
                  f"COMP_WORDS=({' '.join(map(shlex.quote, words))}) COMP_CWORD={len(words) - 1}\n"
                  f"_leeway {words[0]} {shlex.quote(current)} ''\n"
                  "printf '%s\\n' \"${COMPREPLY[@]}\"")
        return output_of("bash", "--norc", "-c", script, cwd=self.work / "root", env=self.environment).split()

    def test_completion_offers_subcommands_options_and_shipped_names(self):
        for line, offered in {"mmg-sim thru": ["thruster-pulses"],
                              "mmg-sim turning --wind-d": ["--wind-dir-deg"],
                              "mmg-sim turning --wind s": ["steady", "stochastic"],
                              "mmg-sim turning --seed 3 --ship kvlcc2": ["kvlcc2-full", "kvlcc2-l7"],
                              "mmg-sim turning --ship=esso": ["esso-osaka-3m"],
                              "mmg-sim import --columns hs": ["hsva-kvlcc2"],
                              "mmg-sim effects wave": ["wave-drift"],
                              "mmg-sim dataset de": ["demo"],
                              "mmg-sim show kvlcc2-l7 u": [],
                              "ens-train --config ho": ["honest"],
                              "gap-explain --fail": ["--fail-on-mismatch"],
                              "leeway-bench ga": ["gap"],
                              "mmg-sim turning --duration-s ": []}.items():
            self.assertEqual(self.completed(line), offered, line)

    def test_completion_works_at_a_prompt(self):
        folder = self.work / "prompt"
        folder.mkdir()
        (folder / "a recording.csv").write_text("t_s,u_mps\n")
        master, slave = pty.openpty()
        shell = subprocess.Popen(["bash", "--norc", "--noprofile", "-i"], cwd=folder, stdin=slave, stdout=slave, stderr=slave,
                                 env={**self.environment, "TERM": "dumb", "HISTFILE": ""}, start_new_session=True)
        os.close(slave)

        def type_until(keys: str, name: str):
            os.write(master, keys.encode())
            end, seen = time.monotonic() + 60, b""
            while not (folder / name).exists():
                self.assertLess(time.monotonic(), end, seen)
                if select.select([master], [], [], 0.1)[0]:
                    seen += os.read(master, 4096)

        try:
            completion = self.root / "usr/share/bash-completion/completions/mmg-sim"
            type_until(f"source '{completion}' && touch ready\n", "ready")
            type_until("mmg-sim sho\tkvlcc2-l\t-o shown\n", "shown")
            type_until("mmg-sim imp\t a\t --col\t hs\t -o x; touch tried-\"$?\"\n", "tried-3")  # read, and no such recording
        finally:
            os.killpg(shell.pid, signal.SIGKILL)
            shell.wait()
            os.close(master)

    @unittest.skipIf(shutil.which("lintian") is None, "lintian is not installed")
    def test_lintian_finds_no_error(self):
        run = subprocess.run(["lintian", "--fail-on", "error", self.package], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    missing = [tool for tool in NEEDED if shutil.which(tool) is None]
    if missing:
        print(f"SKIPPED: no {', '.join(missing)} here: no package is made", file=sys.stderr)
        sys.exit(SKIPPED)
    unittest.main(verbosity=2)
