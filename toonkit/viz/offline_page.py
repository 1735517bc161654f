"""A relit picture as one HTML file, whose reader drags the light: it needs neither Python nor a network."""

from __future__ import annotations

import base64
import json
import zlib

from numpy.typing import ArrayLike

from toonkit._validation import of_type
from toonkit.analysis import ToonAnalysis
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.model.light import direction_of, light_angles
from toonkit.viz.relight_page.scripts import VIEW, joined
from toonkit.viz.relight_page.textures import describe_picture, encode_recolored

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline' blob:; \
style-src 'unsafe-inline'; img-src data: blob:">
<title>Relit with toonkit</title>
<style>
:root {{
  color-scheme: light dark;
  --panel-on-surface-color: #1c1c1e; --panel-surface-color: #fff; --panel-primary-color: #e07a1f;
}}
@media (prefers-color-scheme: dark) {{
  :root {{ --panel-on-surface-color: #f4f2ee; --panel-surface-color: #121214; }}
}}
body {{
  margin: 0; padding: 16px; background: var(--panel-surface-color); font-family: system-ui, sans-serif;
  container-type: inline-size;
}}
</style>
</head>
<body>
<script type="module">
{script}
const described = {described}
const textures = {textures}
for (const [name, text] of Object.entries(textures)) {{
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))
  described[name] = await new Response(stream).arrayBuffer()
}}
document.body.append(render({{model: {{...described, on() {{}}}}}}))
</script>
</body>
</html>
"""


def write_offline_page(analysis: ToonAnalysis, path: PathLike, light: ArrayLike) -> None:
    """
    Write a page that shows an analyzed picture under a light that its reader drags.

    Parameters
    ----------
    analysis : ToonAnalysis
        The picture taken apart.
    path : path
        Ends in .html.
    light : array_like, shape (3,) or (2,)
        The light to begin with.

    Raises
    ------
    ToonkitError
        If the analysis is not a `ToonAnalysis`, the light is invalid, the suffix is another, or the file cannot be written.
    """
    of_type("analysis", analysis, ToonAnalysis)
    suffix_of(path, (".html",))
    described = {
        **describe_picture(analysis, keep_detail=True),
        "recolored": encode_recolored(analysis),
        "heading": "Relit",
        "new_light": list(light_angles(direction_of("light", light))),
        "light_color": "#ffffff",
        "keep_detail": True,
        "flat_shading": 1.0,
        "ambient": 0.0,
    }
    textures = {
        name: base64.b64encode(zlib.compress(described.pop(name), 6)).decode()
        for name in [name for name, value in described.items() if isinstance(value, bytes)]
    }
    script = joined(VIEW).replace("export default {render}", "")
    page = _PAGE.format(script=script, described=json.dumps(described), textures=json.dumps(textures))
    with atomic_write(path) as file:
        file.write(page.encode())
