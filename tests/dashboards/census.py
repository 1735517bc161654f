"""A Panel plugin: what the server still holds of its visitors, at /census."""

from __future__ import annotations

import gc
import json
from collections import Counter

from tornado.web import RequestHandler

COUNTED = {"Page", "ServerSession"}


class Census(RequestHandler):
    def get(self):
        gc.collect()
        counts, sizes = Counter(), []
        for thing in gc.get_objects():
            name = type(thing).__name__
            if name in COUNTED:
                counts[name] += 1
            elif name == "ToonAnalysis":
                sizes.append(max(thing.image.shape))
        self.write(json.dumps({"counts": counts, "analyses": sizes}))


ROUTES = [("/census", Census, {})]
