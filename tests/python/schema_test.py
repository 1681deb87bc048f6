"""The JSON schema of experiment files against another program's validator: what comes with Skein is valid, and mistakes are not."""
import json
import pathlib
import sys
import tomllib

try:
    import jsonschema
except ImportError:
    print("skipped: python3-jsonschema is not installed")
    sys.exit(77)

source = pathlib.Path(__file__).parents[2] / "resources"
schema = json.loads((source / "experiment.schema.json").read_text())
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)

valid = sorted((source / "experiments").glob("*.toml"))
for file in valid:
    for error in validator.iter_errors(tomllib.loads(file.read_text())):
        sys.exit(f"{file.name}: {list(error.absolute_path)}: {error.message}")

mistakes = [
    "raet = 25", "rate = 0", 'robots_file = 3', "[robot]\ntag = 1", "[[robot]]\ntagg = 1", '[[robot]]\ntag = "1"',
    "[[robot]]\nstart = [0, 0]", '[[robot]]\nmodel = "epuck3"', "[[obstacle]]\nx = 0\ny = 0", "[[perturb]]\nt = 1",
    '[reference]\npath = { shape = "square" }', "[reference]\npath = { points = [[0, 0, 0]] }",
    '[controller.gains]\nk_xx = "much"', "[controller.gains]\nk_xx = [[1, 2]]", "[[gain_change]]\nk_xx = 0.01",
    '[[camera.also]]\nsource = "none"\nalso = []', '[[operator]]\nt = 1\nsays = "hold r1"',
]
missed = [mistake for mistake in mistakes if validator.is_valid(tomllib.loads(mistake))]
if missed:
    sys.exit(f"valid by the schema, but mistakes: {missed}")
print(f"{len(valid)} experiments are valid, {len(mistakes)} mistakes are not")
