"""What commands leave behind that are killed at random moments, and what the next run makes of it.

    python -m benchmarks.kills -o benchmarks/results/kills.csv

Starts `toonkit` again and again on the same output, and kills it (SIGKILL) at a moment drawn from the time that it takes.
After each kill, every file has to be a whole one. After every few kills, a run that is left alone has to end with the files
of an undisturbed one and no temporary file. Writes one row for each command.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import pandas as pd

from toonkit.study.table import TIMING_COLUMNS

KILLS = 30
KILLS_BEFORE_A_WHOLE_RUN = 3
SEED = 20_260_701

COMMANDS = {
    "analyze": ("analyze", "sample:cat", "--engine", "godot", "-o", "{out}/analysis"),
    "orbit": ("relight", "{analysis}", "--orbit", "{out}/orbit.webp"),
    "export": (
        *("relight", "{analysis}", "--light", "30,40", "-o", "{out}/relit.png"),
        *("--layers", "{out}/layers.psd", "--profiles", "{out}/profiles"),
    ),
    "study": (
        *("study", "run", "-o", "{out}/study", "--size", "64", "--workers", "2"),
        *("--shapes", "sphere", "cone", "--maps", "terracotta", "ocean", "--methods", "lumo", "lambert"),
    ),
}
"""Arguments of `toonkit`: `out` is the folder that is watched, `analysis` one that `analyze` has written."""

TIMES = {"seconds", "runs"}
"""What no two runs have in common in their JSON files."""

REWRITTEN = ("report.json", "study.json", "trials.parquet")
"""Files that a run writes more than once: when it is killed they are whole, but may be of an earlier moment. While the files
of an analysis are replaced, its report does not vouch for them."""


@dataclass
class Findings:
    """What one command left behind: only `kills`, `whole` and `temporary` may be other than 0."""

    command: str
    kills: int = 0
    whole: int = 0
    """Files found whole after the kills, summed up."""
    temporary: int = 0
    """Temporary files found after the kills: of so many the writing was interrupted."""
    half: int = 0
    """Files that cannot be read, or are not those of an undisturbed run."""
    stray: int = 0
    """Temporary files after a run that was left alone."""
    different: int = 0
    """Files that differ from those of an undisturbed run, or are missing, after a run that was left alone."""


def is_temporary(path: Path) -> bool:
    return path.suffix == ".tmp"


def files_in(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def without_times(value: Any) -> Any:
    """Return a JSON value without what no two runs have in common."""
    if isinstance(value, dict):
        return {key: without_times(inner) for key, inner in value.items() if key not in TIMES}
    return [without_times(inner) for inner in value] if isinstance(value, list) else value


def content(path: Path) -> bytes:
    """Return a file without times; what is not whole raises."""
    data = path.read_bytes()
    if path.suffix == ".json":
        return json.dumps(without_times(json.loads(data)), sort_keys=True).encode()
    if path.suffix == ".parquet":
        return pd.read_parquet(BytesIO(data)).drop(columns=TIMING_COLUMNS).to_csv().encode()
    return data


def contents(folder: Path) -> dict[str, bytes]:
    """Return all but temporary files, by their paths inside a folder."""
    return {
        str(path.relative_to(folder)): content(path) for path in files_in(folder) if not is_temporary(path)
    }


def is_whole(path: Path, expected: bytes | None) -> bool:
    """Tell whether a file can be read, and is the expected one unless a command writes it more than once."""
    try:
        return content(path) == expected or path.name in REWRITTEN
    except (ValueError, OSError):
        return False


def command_line(arguments: Sequence[str]) -> list[str]:
    return [sys.executable, "-m", "toonkit", *arguments, "--quiet"]


def run_whole(arguments: Sequence[str]) -> float:
    """Run `toonkit` to its end, and return the seconds that it took."""
    begun = time.monotonic()
    subprocess.run(command_line(arguments), check=True)
    return time.monotonic() - begun


def kill_at(arguments: Sequence[str], seconds: float) -> bool:
    """Run `toonkit` for some seconds at most; False if it ended before. Its own workers are left to end by themselves."""
    with subprocess.Popen(command_line(arguments), stderr=subprocess.DEVNULL) as process:
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            process.kill()
            return True
    return False


def look(folder: Path, expected: dict[str, bytes], found: Findings) -> None:
    """Note what a killed command has left."""
    for path in files_in(folder):
        if is_temporary(path):
            found.temporary += 1
        elif is_whole(path, expected.get(str(path.relative_to(folder)))):
            found.whole += 1
        else:
            found.half += 1


def compare(folder: Path, expected: dict[str, bytes], found: Findings) -> None:
    """Note what a command has left that was not killed."""
    found.stray += sum(map(is_temporary, files_in(folder)))
    result = contents(folder)
    found.different += sum(result.get(name) != expected.get(name) for name in {*result, *expected})


def measured(command: str, kills: int, generator: random.Random, folder: Path) -> Findings:
    """Kill one command so many times."""
    found, analysis = Findings(command), folder / "analysis"
    if not analysis.exists():
        run_whole(("analyze", "sample:cat", "-o", str(analysis)))

    def arguments(out: Path) -> list[str]:
        out.mkdir(exist_ok=True)
        return [part.format(out=out, analysis=analysis) for part in COMMANDS[command]]

    undisturbed, out = folder / f"{command}-undisturbed", folder / command
    seconds = run_whole(arguments(undisturbed))
    expected = contents(undisturbed)
    while found.kills < kills:
        killed = kill_at(arguments(out), generator.uniform(0, seconds))
        if killed:
            found.kills += 1
            look(out, expected, found)
            if found.kills % KILLS_BEFORE_A_WHOLE_RUN and found.kills < kills:
                continue
            run_whole(arguments(out))
        compare(out, expected, found)
        shutil.rmtree(out)
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="What killed commands leave behind.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per command")
    parser.add_argument("--kills", type=int, default=KILLS, help=f"kills of each command (default: {KILLS})")
    parser.add_argument("--commands", nargs="+", choices=list(COMMANDS), default=list(COMMANDS))
    parser.add_argument("--seed", type=int, default=SEED, help="draws the moments")
    given = parser.parse_args(arguments)
    generator = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as folder:
        rows = pd.DataFrame(
            asdict(measured(command, given.kills, generator, Path(folder))) for command in given.commands
        )
    print(rows.to_string(index=False))
    if given.output is not None:
        rows.to_csv(given.output, index=False)


if __name__ == "__main__":
    main()
