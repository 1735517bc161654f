"""Files that other programs read: pictures, normal maps, color maps, animations, archives of an analysis."""
