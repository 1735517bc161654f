"""Figures for print: the paper's, and those of the study, drawn with matplotlib in one house style."""
