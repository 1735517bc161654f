"""Training: its loss falls, it goes on from a checkpoint as if nothing had been, and what it measures is in degrees."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest
import torch
from scipy.stats import vonmises_fisher
from torch import Tensor, nn

from tests.training.shapes import ellipsoids
from toonkit import ToonkitError, light_direction
from toonkit.estimation.shape_prior import features
from toonkit.estimation.working_square import SIZE
from toonkit.training import light_task, shape_task, train
from toonkit.training.drawings import INKED, OUTLINED, Drawing, Drawings
from toonkit.training.light_task import LightTask
from toonkit.training.network import export_weights
from toonkit.training.shape_task import ColoredShapeTask, ShapeTask, chord
from toonkit.training.train import Training, TrainingOptions

pytestmark = pytest.mark.usefixtures("narrow", "one_thread")

TASKS = pytest.mark.parametrize(
    "task", [ShapeTask, ColoredShapeTask, LightTask], ids=["shape", "colored", "light"]
)


def options(steps: int = 6, **others: float) -> TrainingOptions:
    return TrainingOptions(**{"steps": steps, "batch": 4, "warmup": 2, **others})


def drawings(count: int = 3) -> Drawings:
    return Drawings(ellipsoids(count), 0, count)


class OneBatch(Drawings):
    """The same four drawings in every step."""

    def draw(self, rng: np.random.Generator, *, turned: bool, **others: object) -> Drawing:
        del rng, others
        object.__setattr__(self, "last", (self.last + 1) % 4)
        return Drawings(self.dataset, 0, len(self.dataset)).draw(
            np.random.default_rng(self.last), turned=turned
        )


class Slope:
    """A task of one number whose loss always falls to the right."""

    name = "slope"

    def network(self) -> nn.Module:
        return nn.Linear(1, 1, bias=False)

    def loss(self, network: nn.Module, *others: object) -> tuple[Tensor, float]:
        del others
        return -network(torch.ones(1, 1)).sum(), 0.0

    def figures(self, average: nn.Module, drawings: Drawings, count: int) -> dict[str, float]:
        return {}


def advanced(training: Training, steps: int) -> Training:
    for _ in range(steps):
        training.advance(drawings())
    return training


def states(training: Training) -> dict[str, Tensor]:
    parts = {"network": training.network.state_dict(), "average": training.average.state_dict()}
    moments = training.optimizer.state_dict()["state"]
    parts["optimizer"] = {
        f"{k}.{name}": value for k, state in moments.items() for name, value in state.items()
    }
    return {f"{part}.{name}": value for part, state in parts.items() for name, value in state.items()}


def differences(first: Training, second: Training) -> list[str]:
    ours, theirs = states(first), states(second)
    assert ours.keys() == theirs.keys()
    return [name for name in ours if not torch.equal(ours[name], theirs[name])]


@TASKS
def test_a_training_repeats_itself(task) -> None:
    first, second = (advanced(Training(task(), options()), 3) for _ in range(2))
    assert differences(first, second) == []
    assert len(differences(first, advanced(Training(task(), options(seed=8)), 3))) > 10


@TASKS
def test_an_interrupted_training_goes_on_as_if_it_had_not_been(task, tmp_path: Path) -> None:
    through = advanced(Training(task(), options()), 5)
    advanced(Training(task(), options()), 3).save(tmp_path / "half.pt")
    torch.manual_seed(99)
    resumed = Training(task(), options())
    resumed.load(tmp_path / "half.pt")
    assert resumed.step == 3
    assert differences(advanced(resumed, 2), through) == []


def test_the_loss_of_one_batch_falls_when_it_is_learned_by_heart() -> None:
    training = Training(ShapeTask(), options(steps=60, rate=0.01, warmup=5))
    batch = OneBatch(ellipsoids(3), 0, 3)
    errors = [training.advance(batch) for _ in range(60)]
    assert errors[0] > 10
    assert np.mean(errors[-5:]) < 0.6 * errors[0]


def test_lights_of_one_batch_are_learned_by_heart() -> None:
    training = Training(LightTask(), options(steps=80, rate=0.01, warmup=5))
    batch = OneBatch(ellipsoids(3), 0, 3)
    errors = [training.advance(batch) for _ in range(80)]
    assert np.mean(errors[:3]) > 40
    assert np.mean(errors[-5:]) < 15


def test_the_rate_rises_in_the_warmup_and_falls_to_nothing() -> None:
    training = Training(Slope(), options(steps=100, rate=0.5, warmup=10))
    rates = []
    for _ in range(100):
        advanced(training, 1)
        rates.append(training.optimizer.param_groups[0]["lr"])
    assert rates[0] == pytest.approx(0.05)
    assert (np.diff(rates[:10]) > 0).all()
    assert (np.diff(rates[10:]) < 0).all()
    assert max(rates) == pytest.approx(0.5, rel=0.03)
    assert rates[-1] < 0.001 * 0.5


def test_the_average_follows_the_weights_at_a_distance() -> None:
    training = Training(Slope(), options(steps=10_000, rate=0.01, decay=0.0))
    (weight,), (mean,) = training.network.parameters(), training.average.parameters()
    values = [weight.item()]
    for _ in range(40):
        advanced(training, 1)
        values.append(weight.item())
    assert (np.diff(values) > 0).all()
    expected = values[0]
    for k, value in enumerate(values[1:], start=1):
        keep = min(train.AVERAGING, (1 + k) / (10 + k))
        expected = keep * expected + (1 - keep) * value
    assert mean.item() == pytest.approx(expected, abs=1e-6)
    assert values[20] < mean.item() < values[-1]


def test_a_checkpoint_remembers_everything(tmp_path: Path) -> None:
    training = advanced(Training(LightTask(), options()), 2)
    training.history.append({"step": 2, "mean": 41.5})
    training.save(tmp_path / "light.pt")
    again = Training(LightTask(), options())
    assert len(differences(advanced(again, 1), training)) > 10
    again.load(tmp_path / "light.pt")
    assert (again.step, again.seconds, again.history) == (2, training.seconds, training.history)
    assert differences(again, training) == []
    assert [path.name for path in tmp_path.iterdir()] == ["light.pt"]


def test_a_training_starts_from_the_average_of_another(tmp_path: Path) -> None:
    first = advanced(Training(LightTask(), options()), 2)
    first.save(tmp_path / "light.pt")
    second = Training(LightTask(), options(seed=8))
    second.start_from(tmp_path / "light.pt")
    assert second.step == 0
    for part in (second.network, second.average):
        for name, value in part.state_dict().items():
            assert torch.equal(value, first.average.state_dict()[name])
    assert second.earlier == [first.record]
    assert "--seed 7" in first.record["command"]
    advanced(second, 1).save(tmp_path / "second.pt")
    third = Training(LightTask(), options())
    third.start_from(tmp_path / "second.pt")
    assert [made["steps"] for made in third.earlier] == [2, 1]
    assert "--start BEFORE" in third.earlier[1]["command"]


@TASKS
def test_a_training_starts_from_weights_that_ship_and_answers_alike(task) -> None:
    """Its normalizations count what they see, and change nothing of it."""
    first = advanced(Training(task(), options()), 2)
    shipped = export_weights(first.average)
    second = Training(task(), options(seed=8))
    second.start_from_weights(shipped, [first.record], drawings())
    assert second.earlier == [first.record]
    for network in (second.network.eval(), second.average):
        again = export_weights(network)
        assert all(np.abs(again[name] - values).max() < 1e-4 for name, values in shipped.items())
    norm = second.network.encoder.stem.norm
    assert (norm.running_var > 0).all()
    assert norm.running_mean.abs().max() > 0.01
    assert np.allclose(norm.weight.detach() ** 2, norm.running_var + norm.eps, rtol=1e-4)


def test_nothing_can_be_kept_of_no_start() -> None:
    with pytest.raises(ToonkitError, match=r"keep needs weights to start from; got 0\.5"):
        Training(LightTask(), options(keep=0.5)).shipped()


def test_a_network_that_answers_as_what_ships_is_the_mean_of_both() -> None:
    shipped = export_weights(advanced(Training(LightTask(), options()), 1).average)
    training = Training(LightTask(), options(seed=8, keep=0.25))
    training.start_from_weights(shipped, [], drawings())
    advanced(training, 2)
    mixed, last = export_weights(training.shipped_network()), export_weights(training.average)
    for name, values in shipped.items():
        assert np.allclose(mixed[name], 0.25 * values + 0.75 * last[name], atol=1e-5)


def test_feature_maps_that_weights_do_not_know_count_for_nothing() -> None:
    shipped = export_weights(advanced(Training(LightTask(), options()), 1).average)
    shipped["stem.weight"] = shipped["stem.weight"][:, :-4]  # the last map, in its four parts
    training = Training(LightTask(), options(seed=8))
    training.start_from_weights(shipped, [], drawings())
    again = export_weights(training.average)["stem.weight"]
    assert np.abs(again[:, :-4] - shipped["stem.weight"]).max() < 1e-4
    assert not again[:, -4:].any()


def test_weights_that_ask_for_more_feature_maps_are_those_of_another_network() -> None:
    shipped = export_weights(Training(LightTask(), options()).network)
    shipped["stem.weight"] = np.concatenate([shipped["stem.weight"], shipped["stem.weight"][:, :4]], axis=1)
    with pytest.raises(ToonkitError, match="start must be weights of the light_prior"):
        Training(LightTask(), options()).start_from_weights(shipped, [], drawings())


@pytest.mark.parametrize(
    ("task", "changed", "words"),
    [
        (ShapeTask, {}, "task must be light_prior, as in the checkpoint light.pt; got shape_prior"),
        (LightTask, {"batch": 5}, "batch must be 4, as in the checkpoint light.pt; got 5"),
        (LightTask, {"seed": 8}, "seed must be 7"),
        (LightTask, {"steps": 9}, "steps must be 6"),
        (LightTask, {"rate": 0.1}, r"rate must be 0\.002"),
    ],
)
def test_a_checkpoint_of_another_training_is_refused(task, changed, words, tmp_path: Path) -> None:
    Training(LightTask(), options()).save(tmp_path / "light.pt")
    other = Training(task(), options(**changed))
    with pytest.raises(ToonkitError, match=words):
        other.load(tmp_path / "light.pt")
    assert other.step == 0


def test_a_checkpoint_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "light.pt"
    training = advanced(Training(LightTask(), options()), 1)
    training.save(path)
    before = path.read_bytes()

    def full_disk(state: object, file: BinaryIO) -> None:
        file.write(b"half of it")
        raise OSError("no space left on device")

    monkeypatch.setattr(torch, "save", full_disk)
    with pytest.raises(ToonkitError, match="no space"):
        advanced(training, 1).save(path)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("task", "learned", "colored"),
    [
        (ShapeTask(), (True, INKED), False),
        (ColoredShapeTask(), (True, OUTLINED), True),
        (LightTask(), (False, INKED), False),
    ],
)
def test_only_shapes_are_learned_under_doubtful_lights_and_all_are_judged_with_ink_and_without(
    task, learned, colored, monkeypatch: pytest.MonkeyPatch
) -> None:
    noted = []
    draw = Drawings.draw

    def noting(self: Drawings, rng: np.random.Generator, **asked: bool) -> Drawing:
        noted.append((asked.get("doubtful", False), asked["inked"], asked.get("colored", False)))
        return draw(self, rng, **asked)

    monkeypatch.setattr(Drawings, "draw", noting)
    network = task.network().eval()
    task.loss(network, drawings(), np.random.default_rng(0), 4)
    task.figures(network, drawings(), 4)
    asked = [(*learned, colored), (False, 0.0, colored), (False, 1.0, colored)]
    assert noted == [each for each in asked for _ in range(4)]


def test_the_network_is_told_how_much_the_light_of_a_drawing_is_in_doubt(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = []

    def noting(*described: object) -> np.ndarray:
        told.append(described[-1])
        return features(*described)

    monkeypatch.setattr(shape_task, "features", noting)
    network = ShapeTask().network().eval()
    ShapeTask().loss(network, drawings(), np.random.default_rng(0), 8)
    rng = np.random.default_rng(0)
    drawn = [drawings().draw(rng, turned=False, doubtful=True, inked=INKED) for _ in range(8)]
    assert told == [item.doubt for item in drawn]
    assert 0.0 in told
    assert max(told) > 0.0


def unpainted(mask: np.ndarray, truth: np.ndarray) -> Drawing:
    tones, light = np.zeros(mask.shape, np.float32), light_direction(0, 40).astype(np.float32)
    nothing = np.zeros_like(mask)
    return Drawing(tones, nothing, None, mask, truth, truth, light, 0.0)


def test_the_error_of_tilted_normals_is_their_tilt() -> None:
    mask = np.zeros((SIZE, SIZE), bool)
    mask[20:70, 10:80] = True
    truth = np.where(mask[..., None], np.float32([0, 0, 1]), np.float32(0))
    item = unpainted(mask, truth)
    tilted = light_direction(0, 80).astype(np.float32)
    change = torch.from_numpy(
        np.broadcast_to((tilted - [0, 0, 1])[:, None, None], (3, SIZE, SIZE)).astype(np.float32)
    )
    error = chord(torch.stack([change, 0 * change]), [item, item])
    # A chord is a little shorter than its arc; and its root is rounded off at 0.001 rad, to have a slope at zero.
    assert error.tolist() == pytest.approx(
        [np.rad2deg(2 * np.sin(np.deg2rad(5))), np.rad2deg(1e-3)], rel=1e-3
    )


def test_a_change_away_from_the_viewer_counts_as_one_to_the_rim() -> None:
    mask = np.ones((SIZE, SIZE), bool)
    truth = np.tile(np.float32([1, 0, 0]), (SIZE, SIZE, 1))
    item = unpainted(mask, truth)
    change = torch.zeros(1, 3, SIZE, SIZE)
    change[:, 2] = -5
    assert chord(change, [item]).item() == pytest.approx(np.rad2deg(1e-3), rel=1e-3)


@pytest.mark.parametrize("raw", [-2.0, 1.0, 4.0])
def test_the_likelihood_of_a_light_is_that_of_a_von_mises_fisher_distribution(raw: float) -> None:
    mean, lights = (
        light_direction(40, 50),
        np.array([light_direction(azimuth, 30) for azimuth in (40, 60, 170, 220)]),
    )
    answer = torch.tensor(np.tile([*(3 * mean), raw], (4, 1)), dtype=torch.float32)
    likelihood, error = light_task._compared(answer, torch.tensor(lights, dtype=torch.float32))
    expected = vonmises_fisher(mean, 0.05 + np.exp(raw)).logpdf(lights)
    assert likelihood.numpy() == pytest.approx(
        expected + np.log(2 * np.pi), abs=1e-4
    )  # up to a constant, this one
    assert error.numpy() == pytest.approx(np.rad2deg(np.arccos(lights @ mean)), abs=1e-2)


@TASKS
def test_figures_are_of_drawings_that_never_change(task) -> None:
    training = advanced(Training(task(), options()), 1)
    first, again = (training.task.figures(training.average, drawings(), 6) for _ in range(2))
    assert first == again
    assert all(0 < degrees < 180 for degrees in first.values())


def test_figures_of_an_untrained_shape_network_are_those_of_inflation() -> None:
    training = Training(ShapeTask(), options())
    figures = training.task.figures(training.average, drawings(), 4)
    assert figures["initial"] > 5
    assert figures["corrected"] == pytest.approx(figures["initial"], rel=1e-4)
