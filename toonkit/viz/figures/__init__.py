"""Figures of the study, drawn with matplotlib, and the style that all printed figures share."""
