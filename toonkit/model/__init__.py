"""How a cartoon picture is formed: c = M(L · N). Knows no estimation."""
