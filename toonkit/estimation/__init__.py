"""The paper's steps, one module a step."""
