"""The schema of autotuning results that tuners share, "T4" 1.0.0, as Kernel Tuner has it; stricter where feeler is."""

from __future__ import annotations

from typing import Any

NUMBER = {"type": "number"}
TEXT = {"type": "string"}

MEASUREMENT = {
    "type": "object",
    "properties": {"name": TEXT, "value": {"type": ["number", "string", "array"]}, "unit": TEXT},
    "required": ["name", "value", "unit"],
    "additionalProperties": False,
}

RESULT = {
    "type": "object",
    "properties": {
        "timestamp": {"type": "string", "pattern": r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$"},
        "configuration": {"type": "object", "minProperties": 1},
        "objectives": {"type": "array", "items": TEXT},
        "times": {
            "type": "object",
            "properties": {
                "compilation_time": NUMBER,
                "runtimes": {"type": "array", "items": {"type": "number", "exclusiveMinimum": 0}},
                "framework": NUMBER,
                "search_algorithm": NUMBER,
                "validation": NUMBER,
            },
            "additionalProperties": False,
        },
        "invalidity": {"enum": ["timeout", "compile", "runtime", "correctness", "constraints", "correct"]},
        "correctness": {"enum": [0, 1]},
        "measurements": {"type": "array", "items": MEASUREMENT},
    },
    "required": ["timestamp", "configuration", "objectives", "times", "invalidity", "correctness", "measurements"],
    "additionalProperties": False,
}

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "type": "object",
    "properties": {
        "schema_version": {"type": "string", "pattern": r"^\d+\.\d+\.\d+$"},
        "results": {"type": "array", "items": RESULT},
    },
    "required": ["schema_version", "results"],
    "additionalProperties": False,
}
