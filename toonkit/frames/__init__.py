"""Frames of sprite sheets and animations, analyzed as views of one object: one light, shared materials, one scale."""
