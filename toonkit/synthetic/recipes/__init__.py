"""What is drawn: characters, animals and things, in random proportions. Neither the study nor the training has them."""

from toonkit.synthetic.recipes import animals as _animals  # noqa: F401  # each module registers its recipes
from toonkit.synthetic.recipes import characters as _characters  # noqa: F401
from toonkit.synthetic.recipes import creatures as _creatures  # noqa: F401
from toonkit.synthetic.recipes import still_lifes as _still_lifes  # noqa: F401
from toonkit.synthetic.recipes import things as _things  # noqa: F401
from toonkit.synthetic.recipes import vehicles as _vehicles  # noqa: F401
from toonkit.synthetic.recipes.registry import RECIPES, Recipe, recipe

__all__ = ["RECIPES", "Recipe", "recipe"]
