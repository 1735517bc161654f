"""Arrays to pictures: HoloViews elements, PyVista scenes, and the relight view. Estimates nothing."""
