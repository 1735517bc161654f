"""What a dashboard still holds once its visitors have left."""

from __future__ import annotations

from contextlib import contextmanager

import pytest

from tests.dashboards.conftest import wait_until_all_have_left
from tests.dashboards.driving import (
    START_SECONDS,
    open_shape,
    open_views,
    show_first_choices,
    show_first_sample,
    upload_ball,
    wait_until_relit,
)

pytestmark = pytest.mark.browser

SIDE = 100  # of no other drawing
FURTHER_VISITORS = range(2)


@contextmanager
def visit(browser, url):
    page = browser.new_page()
    page.goto(url)
    yield page
    page.close()


@pytest.fixture(scope="module", autouse=True)
def all_have_left(request, browser, relight_tab, relight_url, study_tab, study_url):
    """Nobody is on either page any more: neither who has made all other tests, nor two further visitors."""
    failures = request.session.testsfailed
    with relight_tab.lent(failures, show_first_sample) as page:
        upload_ball(page, SIDE)
        open_shape(page)
    relight_tab.leave()
    for _ in FURTHER_VISITORS:
        with visit(browser, relight_url) as page:
            wait_until_relit(page)
            upload_ball(page, SIDE)
            open_shape(page)
            open_views(page)
    with study_tab.lent(failures, show_first_choices):
        pass
    study_tab.leave()
    for _ in FURTHER_VISITORS:
        with visit(browser, study_url) as page:
            page.wait_for_selector(".bk-Figure", timeout=START_SECONDS * 1000)


def test_what_visitors_brought_is_freed_once_they_have_left(relight_url):
    found = wait_until_all_have_left(relight_url)
    assert "ServerSession" not in found["counts"]
    assert found["counts"].get("Page", 0) <= 1  # Panel may keep the first page of a process
    assert SIDE not in found["analyses"]


def test_a_study_page_is_freed_once_its_visitor_has_left(study_url):
    counts = wait_until_all_have_left(study_url)["counts"]
    assert "ServerSession" not in counts
    assert counts.get("Page", 0) <= 1  # Panel may keep the first page of a process
