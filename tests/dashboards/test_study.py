"""The study page, driven as a visitor would."""

from __future__ import annotations

import shutil

import pandas as pd
import pytest
from playwright.sync_api import expect

from tests.dashboards.conftest import served
from tests.dashboards.driving import shown_pictures, until
from toonkit.study.table import CSV_NAME, PROVENANCE_NAME
from toonkit.viz.study_page.page import study_page as study_page_of

pytestmark = pytest.mark.browser

REST_SECONDS = 0.5
# Where on the screen a place of the heat map lies, and what its color bar says.
ON_SCREEN = """([x, y]) => {
  const figure = [...Bokeh.documents[0]._all_models.values()].find((model) => model.type === "Figure")
  const view = Bokeh.index.find_one(figure)
  const box = view.el.getBoundingClientRect()
  const frame = view.frame
  return [box.x + frame.x_scale.compute(x), box.y + frame.y_scale.compute(y)]
}"""
COLOR_BAR = (
    """() => [...Bokeh.documents[0]._all_models.values()].find((model) => model.type === "ColorBar").title"""
)


def choose(page, label, option):
    page.get_by_role("combobox", name=label).click()
    page.get_by_role("menuitem", name=option, exact=True).click()
    page.get_by_role("listbox").wait_for(state="hidden")


def click(page, place):
    """Click on a place of the heat map once the page has come to rest: what is above it moves it while it is laid out."""
    before, seen = None, page.evaluate(ON_SCREEN, place)
    while before != seen:
        page.wait_for_timeout(REST_SECONDS * 1000)
        before, seen = seen, page.evaluate(ON_SCREEN, place)
    page.mouse.click(*seen)


def pictures(page, trial):
    """The pictures of a trial, once all methods have answered."""
    sheet = page.locator(f'.sheet[aria-label="{trial}"]')
    sheet.locator("img[alt='normal map']").nth(6).wait_for()
    return tuple(shown_pictures(page))


def test_the_page_opens_with_a_difference_and_a_trial_for_all_methods(opened_study_page):
    title = opened_study_page.get_by_text("Normals, mean error: toonkit minus Todo & Yamaguchi")
    assert title.is_visible()
    assert opened_study_page.locator(".sheet .name").all_inner_texts()[0].startswith("Truth")
    assert (
        opened_study_page.locator(".sheet .tile img").count() == 7 + 7 + 6 + 4 * 7
    )  # six methods, and the truth


def test_measure_and_methods_change_the_heat_map(study_page):
    choose(study_page, "Measure", "relit, RMSE")
    study_page.get_by_text("Relit, RMSE: toonkit minus Todo & Yamaguchi").wait_for()
    study_page.wait_for_function(f"() => ({COLOR_BAR})().includes('relit, RMSE (sRGB)')")
    choose(study_page, "Measure", "normals, mean error")
    choose(study_page, "Compared with", "nothing")
    study_page.locator('[data-value="flat"]').click()
    study_page.get_by_text("Normals, mean error: Flat").wait_for()
    study_page.get_by_text("1 of 4 cells have no value").wait_for()  # its failed trial is not passed over


def test_a_click_on_a_cell_or_a_name_shows_that_trial(study_page):
    shown = []
    for place, trial in (((0, -1), "cone in terracotta"), ((1, 0), "sphere in ocean")):
        click(study_page, place)
        shown.append(pictures(study_page, trial))
    choose(study_page, "Shape", "cone")
    shown.append(pictures(study_page, "cone in ocean"))
    assert study_page.get_by_text("Cone in ocean").is_visible()
    assert len(set(shown)) == 3


def test_buttons_select_telling_trials_and_a_color_map_can_be_chosen(study_page):
    title = study_page.locator("text=/^(Sphere|Cone) in (terracotta|ocean)$/")
    titles = [title.inner_text()]
    for name in ("Best", "Worst", "Typical"):
        study_page.get_by_role("button", name=name).click()
        expect(title).not_to_have_text(titles[-1])
        titles.append(title.inner_text())
        pictures(study_page, titles[-1].lower())
    assert titles[0] == titles[-1]  # the page opens with the typical one
    other = {"terracotta": "ocean", "ocean": "terracotta"}[titles[-1].split()[-1]]
    choose(study_page, "Color map", other)
    assert pictures(study_page, f"{titles[-1].split()[0].lower()} in {other}")


def test_the_other_light_track_is_examined_with_estimated_lights(study_page):
    trial = study_page.locator(".sheet").get_attribute("aria-label")
    before = pictures(study_page, trial)
    choose(study_page, "Light", "estimated from the picture")
    assert until(study_page, lambda: tuple(shown_pictures(study_page)) != before)
    assert study_page.locator(".sheet").get_attribute("aria-label") == trial


SCRIPT = "<img src=x onerror='window.injected=true'>"


@pytest.fixture
def hostile_url(tmp_path, study_folder):
    """The page of a study whose names and errors are HTML that would run a script."""
    table = pd.read_csv(study_folder / CSV_NAME)
    for column in ("shape", "color_map"):
        table[column] += SCRIPT
    table["method"] = table["method"].replace("lambert", f"lambert{SCRIPT}")
    table["error"] = table["error"].mask(table["error"].notna(), f"ToonkitError: {SCRIPT}")
    table.to_csv(tmp_path / CSV_NAME, index=False)
    shutil.copy(study_folder / PROVENANCE_NAME, tmp_path)
    with served("study", tmp_path / "log", tmp_path) as url:
        yield url


def test_names_and_errors_of_a_study_run_no_script(page, hostile_url, complaints):
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(hostile_url)
    page.get_by_text(SCRIPT).first.wait_for()
    page.wait_for_selector(".bk-Figure")
    for place in ((0, -1), (1, 0)):
        click(page, place)
        page.wait_for_timeout(REST_SECONDS * 1000)  # for its hover text
    page.locator('[data-value="flat"]').click()
    page.wait_for_timeout(REST_SECONDS * 1000)
    page.get_by_role("combobox", name="Shape").click()
    page.get_by_role("menuitem").first.wait_for()
    assert page.evaluate("window.injected") is None


def test_without_a_study_the_page_says_how_to_make_one(tmp_path):
    page = study_page_of(tmp_path)
    ((message,),) = page.main[0]
    assert "toonkit study run -o study/" in message.object
    assert str(tmp_path) in message.object
