"""What all tests share: a skip is a failure on CI and a loud notice elsewhere; the system's Chromium."""

from __future__ import annotations

import os
import shutil
from collections.abc import Generator
from typing import Any

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

ON_CI = os.environ.get("CI", "").lower() not in ("", "0", "false")

CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM_ARGUMENTS = [
    "--no-sandbox",  # CI is root, and Chromium refuses to sandbox root
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def _forbid_skip(report: pytest.TestReport | pytest.CollectReport) -> None:
    """Turn a skipped report into a failed one; an expected failure is a fact about the code and stays."""
    if ON_CI and report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[-1] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome = "failed"
        report.longrepr = f"CI may not skip {report.nodeid}: {reason}"


class _FileByFile(LoadScopeScheduling):
    """Keeps the tests of a file, and all that drive a browser, in one process: two browsers at once are too slow."""

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        return "dashboards" if file.startswith("tests/dashboards/") else file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> _FileByFile:
    """Hand out the tests in their order, since those that take longest come first: the browser's."""
    config.option.loadscopereorder = False
    return _FileByFile(config, log)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    _forbid_skip(report)
    return report


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    _forbid_skip(report)
    return report


def pytest_terminal_summary(terminalreporter: Any) -> None:
    skipped = len(terminalreporter.stats.get("skipped", ()))
    if skipped:
        terminalreporter.section("SKIPPED TESTS", sep="!", red=True, bold=True)
        terminalreporter.line(
            f"{skipped} skipped, for the reasons listed. With CI=true each of them is a failure."
        )


@pytest.fixture(scope="session")
def browser_type_launch_args(browser_type_launch_args: dict[str, Any]) -> dict[str, Any]:
    """Launch the system's Chromium rather than one that Playwright would have to download."""
    found = [path for path in map(shutil.which, CHROMIUM_NAMES) if path]
    executable = {"executable_path": found[0]} if found else {}
    return {**browser_type_launch_args, **executable, "args": CHROMIUM_ARGUMENTS}


@pytest.fixture(scope="session")
def base_url() -> None:
    """No base address: the plugin's own fixture of this name is declared in a way that pytest deprecates."""


# The same examples in every run on CI: a failure there is the change's own, and can be repeated.
settings.register_profile("ci", derandomize=True, deadline=None)
if ON_CI:
    settings.load_profile("ci")
