"""YAML as people mean it: keys told once, 1e5 is a number, and nothing but one named error, whatever the text."""

from __future__ import annotations

import re

import yaml

MERGE_TAG = "tag:yaml.org,2002:merge"
FLOAT_TAG = "tag:yaml.org,2002:float"
# The core schema of YAML 1.2 (section 10.3.2), whose floats need neither a point nor a signed exponent.
FLOAT_PATTERN = re.compile(
    r"^(?:[-+]?(?:\.[0-9]+|[0-9]+\.[0-9]*|[0-9]+(?=[eE]))(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$"
)


class YamlTextError(ValueError):
    """A text that is not YAML, or says a key twice; the text of the error says what and where."""


def parse_yaml(text: str) -> object:
    """Return the plain data of a YAML document.

    Raises
    ------
    YamlTextError
        With line and column where they are known.
    """
    try:
        return yaml.load(text, _Loader)
    except _DuplicateKeyError as error:
        raise YamlTextError(str(error)) from None
    except RecursionError:
        raise YamlTextError("not YAML that can be read: nested too deeply") from None
    except (yaml.YAMLError, ValueError) as error:  # a date that no calendar has is a ValueError
        mark = getattr(error, "problem_mark", None)
        place = f" (line {mark.line + 1}, column {mark.column + 1})" if mark else ""
        raise YamlTextError(f"not YAML{place}") from None


class _DuplicateKeyError(Exception):
    """A mapping has a key twice."""


class _Loader(yaml.SafeLoader):
    """Safe loader that refuses a key that is told twice, where YAML 1.1 loaders silently keep the last."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[object, object]:
        first_lines: dict[str, int] = {}
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode) or key.tag == MERGE_TAG:
                continue
            line = key.start_mark.line + 1
            if key.value in first_lines:
                raise _DuplicateKeyError(
                    f"key '{key.value}' is told in line {first_lines[key.value]} and again in line {line}"
                )
            first_lines[key.value] = line
        mapping: dict[object, object] = super().construct_mapping(node, deep)
        return mapping


_Loader.yaml_implicit_resolvers = {
    letter: [(tag, pattern) for tag, pattern in resolvers if tag != FLOAT_TAG]
    for letter, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(FLOAT_TAG, FLOAT_PATTERN, list("-+0123456789."))
