"""Take the pictures of the gallery from a built site whose notebooks were run: `python -m docs.gallery build/site`."""

from __future__ import annotations

import argparse
import io
import shutil
from pathlib import Path

from PIL import Image, ImageChops
from playwright.sync_api import sync_playwright

FOLDER = Path(__file__).parent / "figures" / "gallery"
SIZE = (640, 480)
"""Pixels: twice the size on the page."""

MARGIN = 8

OUTPUTS = {
    "a_new_method": 0,
    "ablation": 0,
    "figure_1_stylized_shading": -1,
    "figure_2_method_overview": -1,
    "figure_3_inflation": -1,
    "figure_4_color_map_estimation": -1,
    "figure_5_illumination_constraints": -1,
    "figure_6_data_sets": -1,
    "figure_7_shading_analysis": -1,
    "figure_8_relighting": -1,
    "first_steps": 5,
    "real_drawings": 6,
    "study_summary": 1,
}
"""Notebook -> which of its outputs is its picture."""

SHOWN = ".cell_output img, .cell_output .output.text_html"
"""Outputs that count: pictures, and tables or charts."""

ALONE = ".bd-header, .bd-sidebar-primary, .bd-sidebar-secondary { display: none !important }"
"""Hides what would cover a tall output."""


def take_pictures(site: Path) -> None:
    """Write one picture for each notebook."""
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1000, "height": 1600}, device_scale_factor=2)
        for name, number in OUTPUTS.items():
            page.goto((site / "notebooks" / f"{name}.html").resolve().as_uri(), wait_until="load")
            page.add_style_tag(content=ALONE)
            page.wait_for_timeout(3000)  # until charts are drawn
            shown = page.locator(SHOWN).nth(number)
            with Image.open(io.BytesIO(shown.screenshot())) as picture:
                _on_white(picture).save(FOLDER / f"{name}.webp", quality=82, method=6)
        browser.close()


def _on_white(picture: Image.Image) -> Image.Image:
    """Trim the white around a picture, and center it on white of the gallery's size."""
    picture = picture.convert("RGB")
    picture = picture.crop(ImageChops.difference(picture, Image.new("RGB", picture.size, "white")).getbbox())
    picture.thumbnail((SIZE[0] - 2 * MARGIN, SIZE[1] - 2 * MARGIN), Image.Resampling.LANCZOS)
    ground = Image.new("RGB", SIZE, "white")
    ground.paste(picture, ((SIZE[0] - picture.width) // 2, (SIZE[1] - picture.height) // 2))
    return ground


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("site", type=Path, help="folder of the site")
    take_pictures(parser.parse_args().site)
