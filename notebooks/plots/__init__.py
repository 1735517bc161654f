"""What the notebooks draw with matplotlib: the figures of the paper, the ablation, and tables of the study."""
