from __future__ import annotations

import numpy as np
import pytest
from conftest import QUICK

import klieg


@pytest.fixture(scope="module", params=["cpu", "vulkan"])
def evaluator(request: pytest.FixtureRequest, pair: klieg.Scene, view: klieg.View) -> klieg.Evaluator:
    return klieg.Evaluator(pair, view, device=request.param)


RIGS = np.array([[[30, 45, 3, 1, 1], [10, -50, 3, 0.4, 0.4]], [[60, 0, 2, 1, 0.5], [0, 90, 4, 0.2, 0.1]]])


def test_scores_of_arrays_are_those_of_lights_and_of_their_terms(evaluator: klieg.Evaluator) -> None:
    scores = evaluator.evaluate(RIGS)
    assert scores.shape == (2,)
    assert scores.dtype == np.float32
    rigs = [[klieg.Light(*key), klieg.Light(*fill, role="fill")] for key, fill in RIGS]
    assert np.array_equal(scores, evaluator.evaluate(rigs))
    terms = evaluator.terms(RIGS)
    weights = klieg.Objective.of("natural").weights
    total = sum(weights[name] * values for name, values in terms.items())
    assert total == pytest.approx(scores, abs=1e-4)
    score, of_one, picture = evaluator.inspect(rigs[0])
    assert score == pytest.approx(scores[0], abs=1e-4)
    assert of_one["mean"] == pytest.approx(terms["mean"][0], abs=1e-4)
    assert picture.shape == (72, 96)
    assert 0 < picture.max() <= 1


def test_more_columns_are_size_and_colour(evaluator: klieg.Evaluator) -> None:
    white = np.concatenate([RIGS, np.zeros((2, 2, 1)), np.ones((2, 2, 3))], axis=2)
    assert np.array_equal(evaluator.evaluate(RIGS), evaluator.evaluate(white))
    red = white.copy()
    red[..., 7:] = 0.1
    assert not np.array_equal(evaluator.evaluate(red), evaluator.evaluate(white))
    directional = evaluator.evaluate(RIGS, kind="directional", roles=["key", "rim"])
    assert not np.array_equal(directional, evaluator.evaluate(RIGS))


def test_genes_are_what_a_search_changes(evaluator: klieg.Evaluator) -> None:
    names, bounds, start = evaluator.genes, evaluator.bounds, evaluator.start()
    assert names[0] == "key 0 elevation"
    assert bounds.shape == (len(names), 2)
    assert start.shape == (len(names),)
    assert (bounds[:, 0] <= start).all()
    assert (start <= bounds[:, 1]).all()
    rig = evaluator.lights(start)
    assert [light.role for light in rig] == ["key", "fill"]
    assert np.array_equal(evaluator.evaluate_genes([start]), evaluator.evaluate([rig]))


def test_maps_of_the_view(evaluator: klieg.Evaluator, pair: klieg.Scene) -> None:
    maps = evaluator.maps()
    shapes = {name: values.shape for name, values in maps.items()}
    vectors = {"position", "normal", "face", "base_color", "emissive"}
    assert vectors < set(shapes)
    assert all(shape == ((72, 96, 3) if name in vectors else (72, 96)) for name, shape in shapes.items())
    objects = maps["code"] > 0
    assert maps["code"].max() <= pair.polygons
    assert np.array_equal(objects, maps["types"] > 0)
    assert np.allclose(np.linalg.norm(maps["normal"][objects], axis=1), 1, atol=1e-4)
    labels, directions = evaluator.clusters(3)
    assert np.array_equal(labels > 0, objects)
    assert directions.shape == (3, 3)
    assert set(np.unique(labels)) <= {0, 1, 2, 3}


def test_the_final_picture_is_that_of_the_design(pair: klieg.Scene, view: klieg.View) -> None:
    result = klieg.design(pair, view, device="cpu", **QUICK)
    evaluator = klieg.Evaluator(pair, view, device="cpu")
    assert np.array_equal(evaluator.picture(result.lights), result.picture())
    assert evaluator.evaluate([result.lights])[0] == np.float32(result.score)
    assert evaluator.device.type == "cpu"


@pytest.mark.parametrize(
    ("lights", "words"),
    [
        (np.zeros((2, 5)), "axes"),
        (np.zeros((1, 1, 4)), "columns"),
        (np.zeros((1, 17, 5)), "17"),
        (np.array([[[0, 0, 0, 1, 1]]]), "distance"),
        (np.array([[[0, 0, 2, -1, 1]]]), "diffuse"),
        (np.array([[[0, 0, 2, np.nan, 1]]]), "diffuse"),
        ("lights", "lights"),
    ],
)
def test_arrays_that_are_no_lights_are_refused(evaluator: klieg.Evaluator, lights: object, words: str) -> None:
    with pytest.raises(klieg.InputError, match=words):
        evaluator.evaluate(lights)  # type: ignore[arg-type]


def test_values_that_are_no_lights_are_refused(evaluator: klieg.Evaluator) -> None:
    with pytest.raises(klieg.InputError, match="roles"):
        evaluator.evaluate(RIGS, roles=["key"])
    with pytest.raises(klieg.InputError, match="genes"):
        evaluator.evaluate_genes([[0.0]])
    with pytest.raises(klieg.InputError, match="distance"):
        klieg.Light(0, 0, -1)
    with pytest.raises(klieg.InputError, match="colour"):
        klieg.Light(0, 0, color="red")
    with pytest.raises(klieg.InputError, match="clusters"):
        evaluator.clusters(0)
