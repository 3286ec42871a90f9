"""Wrong sweeps: one clear message each, from run and validate alike, exit code 2 and no file."""

from pathlib import Path

import pytest

from lienumba import ScenarioError
from tests.facade import resolve
from tests.scenario.checks.refusal import check_refused, refused
from tests.scenario.checks.test_scenario import BASE

HEAD = BASE[: BASE.index("[sweep]")]
MASS = '"bodies.top.mass" = { distribution = "normal", std = 0.1 }'
SPIN = '"bodies.top.angular_velocity[1]" = { distribution = "normal", std = 1 }'


def sweep(*vary: str, keys: str = "runs = 3", after: str = "") -> str:
    """The scenario with these entries of sweep.vary."""
    return HEAD + f"[sweep]\n{keys}\n{after}\n[sweep.vary]\n" + "\n".join(vary) + "\n"


def correlated(paths: str, matrix: str, *vary: str, keys: str = "runs = 3") -> str:
    return sweep(*(vary or (MASS, SPIN)), keys=keys) + f"[[sweep.correlate]]\npaths = {paths}\nmatrix = {matrix}\n"


BOTH = '["bodies.top.mass", "bodies.top.angular_velocity[1]"]'
UNIT = "[[1, 0.5], [0.5, 1]]"
CASES = {
    "unknown distribution": (
        sweep('"bodies.top.mass" = { distribution = "lognorml", sigma = 0.1 }'),
        'sweep.vary."bodies.top.mass".distribution = "lognorml": is not known; the nearest known name is "lognormal"',
    ),
    "choice of texts": (
        sweep('"bodies.top.mass" = { distribution = "choice", values = ["a"] }'),
        'sweep.vary."bodies.top.mass".values[0] = "a": must be a number, not a formula or a parameter; give the values '
        "to choose from, at least one",
    ),
    "median of 0": (
        sweep('"gravity[0]" = { distribution = "lognormal", sigma = 1 }'),
        'sweep.vary."gravity[0]".median: is the nominal value, which is 0, so that every sample is 0; give a '
        "median other than 0",
    ),
    "negative constant": (
        sweep('"bodies.top.mass" = { distribution = "constant", value = -1 }'),
        'sweep.vary."bodies.top.mass": draws only values of 0 or below, which no body has; give values above 0',
    ),
    "text as parameter of scipy": (
        sweep('"bodies.top.mass" = { scipy = "beta", a = 1, b = "1" }'),
        'sweep.vary."bodies.top.mass".b = "1": must be a number, not a text; write it without quotes: 1',
    ),
    "omitted whole": (
        sweep('"bodies.top.velocity" = { distribution = "direction" }'),
        'sweep.vary."bodies.top.velocity": the path bodies.top.velocity leads to a key that is omitted; give its '
        "nominal value first",
    ),
    "column without a table": (
        sweep('"bodies.top.mass" = { column = "m" }'),
        'sweep.vary."bodies.top.mass".column: there is no table; give sweep.sampler = "table" and sweep.table',
    ),
    "no table": (
        sweep(MASS, keys='runs = 3\nsampler = "table"'),
        'sweep.table is missing; give { file = "design.csv" }, a table of samples',
    ),
    "table for nothing": (
        sweep(MASS, keys='runs = 3\ntable = { columns = { "gravity[0]" = [0, 0, 0] } }'),
        'sweep.sampler = "random": takes nothing from sweep.table; give sampler = "table", or leave the table out',
    ),
    "too few rows": (
        sweep(MASS, keys='runs = 3\nsampler = "table"\ntable = { columns = { "gravity[0]" = [0, 0] } }'),
        "sweep.runs = 3: sweep.table has only 2 rows; give at most that many, or leave runs out",
    ),
    "no path in the table": (
        sweep(MASS, keys='sampler = "table"\ntable = { columns = { m = [1, 2] } }'),
        'sweep.table: its column "m", taken as a path, does not exist; numeric paths are such as "gravity[0]", or '
        'let another path vary with it in sweep.vary: { column = "m" }',
    ),
    "unequal columns": (
        sweep(
            MASS,
            keys='runs = 1\nsampler = "table"\ntable = { columns = { "gravity[0]" = [0, 1], "gravity[1]" = [0] } }',
        ),
        "sweep.table: its columns have different lengths (gravity[0]: 2, gravity[1]: 1); give a number for each row",
    ),
    "missing column": (
        sweep(
            '"bodies.top.mass" = { column = "ms" }',
            keys='sampler = "table"\ntable = { columns = { "gravity[0]" = [1, 2] } }',
        ),
        'sweep.vary."bodies.top.mass".column = "ms": is no column of sweep.table; known here are "gravity[0]"',
    ),
    "two rows for a run": (
        sweep(MASS, keys='sampler = "table"\ntable = { columns = { "gravity[0]" = [0, 1] }, runs = [1, 1] }'),
        "sweep.table: has two rows for run 1; give each run one",
    ),
    "no such file": (
        sweep(MASS, keys='sampler = "table"\ntable = { file = "nowhere.csv" }'),
        'sweep.table.file = "nowhere.csv": there is no such file; check the path',
    ),
    "saltelli's runs": (
        sweep(MASS, SPIN, keys='runs = 10\nsampler = "saltelli"'),
        'sweep.runs = 10: must be a multiple of 4 for the sampler "saltelli" with 2 inputs that vary; give 8 or 12',
    ),
    "saltelli of nothing": (
        sweep('"bodies.top.mass" = { distribution = "constant", value = 1 }', keys='runs = 10\nsampler = "saltelli"'),
        'sweep.sampler = "saltelli": no distribution varies; give at least two',
    ),
    "saltelli with correlations": (
        correlated(BOTH, UNIT, keys='runs = 8\nsampler = "saltelli"'),
        'sweep.correlate[0]: the sampler "saltelli" is for inputs that vary independently; leave the correlation '
        'out, or take "sobol"',
    ),
    "small matrix": (
        correlated(BOTH, "[[1, 0.5]]"),
        "sweep.correlate[0].matrix: has 1 row of 2 numbers for 2 paths; give 2 rows of 2",
    ),
    "diagonal": (
        correlated(BOTH, "[[2, 0.5], [0.5, 1]]"),
        "sweep.correlate[0].matrix[0][0] = 2.0: must be 1, the correlation of a path with itself; write 1",
    ),
    "too large": (
        correlated(BOTH, "[[1, 1.5], [1.5, 1]]"),
        "sweep.correlate[0].matrix[0][1] = 1.5: is no correlation; give a number from -1 to 1",
    ),
    "not symmetric": (
        correlated(BOTH, "[[1, 0.5], [0.4, 1]]"),
        "sweep.correlate[0].matrix is not symmetric: [1][0] is 0.4, but [0][1] is 0.5; give both the same value",
    ),
    "correlated constant": (
        correlated(
            '["bodies.top.mass", "gravity[0]"]', UNIT, MASS, '"gravity[0]" = { distribution = "constant", value = 1 }'
        ),
        'sweep.correlate[0].paths[1] = "gravity[0]": is not drawn from a distribution; correlate what is',
    ),
}

# More of these rules: the place, and words of the rule.
MORE = {
    "sweep.sampler: is not known": sweep(MASS, keys='runs = 3\nsampler = "sobel"'),
    'sweep.vary."quantities.tip.derivative": the path quantities.tip.derivative chooses what': sweep(
        '"quantities.tip.derivative" = { distribution = "constant", value = 1, relative = true }'
    ).replace("[sweep]", '[[quantities]]\nname = "tip"\ntype = "point"\nbody = "top"\nderivative = 1\n\n[sweep]', 1),
    'sweep.vary."bodies.top.mass".values: is empty': sweep(
        '"bodies.top.mass" = { distribution = "choice", values = [] }'
    ),
    'sweep.vary."bodies.top.mass".weights: must be as many as there are values, which is': sweep(
        '"bodies.top.mass" = { distribution = "choice", values = [1, 2], weights = [1] }'
    ),
    'sweep.vary."bodies.top.mass": has neither low nor high': sweep(
        '"bodies.top.mass" = { distribution = "truncated_normal", std = 1 }'
    ),
    'sweep.vary."bodies.top.mass".mean: and inf, between which no sample would ever fall': sweep(
        '"bodies.top.mass" = { distribution = "truncated_normal", std = 1, low = 90 }'
    ),
    'sweep.vary."bodies.top.mass".mode: the nominal value': sweep(
        '"bodies.top.mass" = { distribution = "triangular", low = 1, high = 2 }'
    ),
    'sweep.vary."bodies.top.mass".scipy: is no distribution of a number in scipy.stats': sweep(
        '"bodies.top.mass" = { scipy = "lognrom", s = 1 }'
    ),
    'sweep.vary."bodies.top.mass".std: lognorm has no such parameter': sweep(
        '"bodies.top.mass" = { scipy = "lognorm", s = 1, std = 1 }'
    ),
    'sweep.vary."bodies.top.mass".scipy: needs b': sweep('"bodies.top.mass" = { scipy = "beta", a = 1 }'),
    'sweep.vary."bodies.top.mass".scipy: does not exist with a': sweep(
        '"bodies.top.mass" = { scipy = "beta", a = 1, b = -1 }'
    ),
    'sweep.vary."bodies.top.mass": draws only values of': sweep(
        '"bodies.top.mass" = { scipy = "norm", loc = -99, scale = 0.1 }'
    ),
    'sweep.vary."bodies.top.mass": the path bodies.top.mass does not lead to a': sweep(
        '"bodies.top.mass" = { distribution = "rotation_uniform" }'
    ),
    'sweep.vary."bodies.top.rotation": has neither std nor covariance': sweep(
        '"bodies.top.rotation" = { distribution = "rotation_normal" }'
    ),
    'sweep.vary."bodies.top.rotation".covariance: is not positive semi-definite': sweep(
        '"bodies.top.rotation" = { distribution = "rotation_normal", covariance = [[1, 0, 0], [0, 1, 2], [0, 2, 1]] }'
    ),
    'sweep.vary."bodies.top.velocity".distribution: the nominal vector': sweep(
        '"bodies.top.velocity" = { distribution = "direction" }'
    ).replace("[0, 1, 0]", "[0, 1, 0]\nvelocity = [0, 0, 0]"),
    'sweep.vary."bodies.top.rotation": the path bodies.top.rotation is not a vector of': sweep(
        '"bodies.top.rotation" = { distribution = "direction" }'
    ),
    'sweep.vary."bodies.top.inertia".distribution: no body has the nominal inertia': sweep(
        '"bodies.top.inertia" = { distribution = "inertia", std = 0.1 }'
    ).replace("[0.234375, 0.46875, 0.234375]", "[1, 1, 2.5]"),
    'sweep.vary."bodies.top.inertia[0]": the path bodies.top.inertia': sweep(
        '"bodies.top.inertia" = { distribution = "inertia", std = 0.1 }',
        '"bodies.top.inertia[0]" = { distribution = "constant", value = 1 }',
    ),
    'sweep.vary."bodies.top.inertia": the path bodies.top.inertia has the formula': sweep(
        '"bodies.top.inertia" = { distribution = "inertia", std = 0.1 }'
    )
    .replace("[0.234375, 0.46875", '["J", 0.46875')
    .replace("[model]", "[parameters]\nJ = 0.234375\n[model]", 1),
    'sweep.vary."bodies.top.inertia[0]".expression: has the unknown name': sweep(
        MASS, '"bodies.top.inertia[0]" = { expression = "0.01*bodies.top.mas" }'
    ),
    "sweep.vary: bodies.top.mass depends on itself": sweep(
        '"bodies.top.mass" = { expression = "1 + bodies.top.mass" }'
    ),
    "sweep.vary: bodies.top.mass and bodies.top.inertia": sweep(
        '"bodies.top.mass" = { expression = "bodies.top.inertia[0]" }',
        '"bodies.top.inertia[0]" = { expression = "bodies.top.mass" }',
    ),
    'sweep.vary."bodies.top.mass".expression: has a unit': sweep('"bodies.top.mass" = { expression = "2 kg" }'),
    "sweep.correlate[0].paths[1]: does not vary": correlated('["bodies.top.mass", "gravity[0]"]', UNIT),
    "sweep.correlate[0].paths: entry and must have at least": correlated('["bodies.top.mass"]', "[[1]]"),
    "sweep.correlate[0].paths[1]: is there already as sweep.correlate": correlated(
        '["bodies.top.mass", "bodies.top.mass"]', UNIT
    ),
    "sweep.correlate[0].matrix: is not positive semi-definite": correlated(
        '["bodies.top.mass", "bodies.top.angular_velocity[1]", "gravity[0]"]',
        "[[1, 0.9, -0.9], [0.9, 1, 0.9], [-0.9, 0.9, 1]]",
        MASS,
        SPIN,
        '"gravity[0]" = { distribution = "normal", std = 1 }',
    ),
    "sweep.correlate[0].paths[1]: is a rotation": correlated(
        '["bodies.top.mass", "bodies.top.rotation"]',
        UNIT,
        MASS,
        '"bodies.top.rotation" = { distribution = "rotation_normal", std = 1 }',
    ),
    "sweep.correlate[0].paths[1]: is uniform on a sphere or on all rotations": correlated(
        '["bodies.top.mass", "bodies.top.rotation[0]"]',
        UNIT,
        MASS,
        '"bodies.top.rotation" = { distribution = "rotation_uniform" }',
    ),
    "sweep.correlate[0].paths[1]: is a part of a random inertia, which has no": correlated(
        '["bodies.top.mass", "bodies.top.inertia[0]"]',
        UNIT,
        MASS,
        '"bodies.top.inertia" = { distribution = "inertia", std = 0.1 }',
    ),
}


CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize(("text", "message"), CASES.values(), ids=CASES)
def test_bad_sweep(tmp_path: Path, text: str, message: str) -> None:
    check_refused(tmp_path, text, message)


@pytest.mark.parametrize("name", [x for x in CASES if x not in MORE][::9])
def test_validate_and_sample_say_the_same(tmp_path: Path, name: str) -> None:
    text, message = CASES[name]
    assert refused(tmp_path, text, command="sample", output="out.csv") == [message]


@pytest.mark.parametrize(
    "rotation", [{"axis": [0, 0, 0], "angle": 1}, {"axis": [1e300, 0, 0], "angle": 1}, [0, 0, 0, 0], [[0.0] * 3] * 3]
)
def test_a_nominal_rotation_that_is_none(rotation: object) -> None:
    top = {"name": "top", "mass": 1, "inertia": [1, 1, 1], "rotation": rotation}
    vary = {"bodies.top.rotation": {"distribution": "rotation_normal", "std": 0.1}}
    given = {"model": {"bodies": [top]}, "integrator": {"step": 0.1, "end_time": 1}, "sweep": {"runs": 2, "vary": vary}}
    with pytest.raises(ScenarioError, match=r"model\.bodies\.top\.rotation"):
        resolve(given)


def test_a_number_of_a_law_of_ones_own_is_no_rotation_whatever_its_name() -> None:
    path = "forces.shoulder_motor.parameters.target"
    with pytest.raises(ScenarioError, match=f"the path {path} does not lead to a rotation; give one, or a distri"):
        resolve("scenarios/arm_pd.toml", overrides={f'sweep.vary."{path}"': {"distribution": "rotation_uniform"}})
