# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages from plain values and back, over generated ones; and what is wrong is named by its path."""
import random
import unittest

import numpy as np
from support import Case  # isort: skip
from google.protobuf import json_format
from mote import messages

LIST = "google.protobuf.ListValue"
BOUNDS = {1: (-(2**31), 2**31 - 1), 2: (-(2**63), 2**63 - 1), 3: (0, 2**32 - 1), 4: (0, 2**64 - 1)}


def any_scalar(field, numbers):
    if field.cpp_type in BOUNDS:
        return numbers.choice([*BOUNDS[field.cpp_type], numbers.randint(0, 1000)])
    if field.cpp_type in (5, 6):
        return numbers.choice([0.0, -1.5, 1e300, numbers.random()]) if field.cpp_type == 5 else 0.5
    if field.cpp_type == 7:
        return numbers.random() < 0.5
    if field.cpp_type == 8:
        return numbers.choice(field.enum_type.values).number
    return numbers.choice(["", "x", "\u00e4 \u4e2d\n", "a" * 50])


def fill_any(message, numbers, depth=0):
    """Sets about half of the fields, never two of a oneof."""
    if message.DESCRIPTOR.full_name == LIST:
        for _ in range(numbers.randint(0, 3)):
            message.values.add().number_value = numbers.random()
        return
    for field in message.DESCRIPTOR.fields:
        oneof = field.containing_oneof
        if numbers.random() < 0.5 or (oneof and message.WhichOneof(oneof.name)) or field.type == 12:
            continue
        if field.cpp_type == 10:
            if depth > 4:
                continue
            if field.label == 3:
                for _ in range(numbers.randint(0, 2)):
                    fill_any(getattr(message, field.name).add(), numbers, depth + 1)
            else:
                getattr(message, field.name).SetInParent()
                fill_any(getattr(message, field.name), numbers, depth + 1)
        elif field.label == 3:
            getattr(message, field.name).extend([any_scalar(field, numbers) for _ in range(numbers.randint(0, 3))])
        else:
            setattr(message, field.name, any_scalar(field, numbers))


class Round(unittest.TestCase):
    def test_any_message_survives_the_way_through_plain_values(self):
        numbers = random.Random(2)
        for name in ("View", "Selection", "Script", "JobRequest", "Query", "Manifest", "JobStatus"):
            for _ in range(30):
                message = messages.new(name)
                fill_any(message, numbers)
                self.assertEqual(messages.to_message(name, messages.to_dict(message)), message, name)

    def test_plain_values_mean_what_protobuf_s_own_json_means(self):
        numbers = random.Random(3)
        for name in ("View", "Selection", "Script", "JobRequest"):
            for _ in range(30):
                message = messages.new(name)
                fill_any(message, numbers)
                other = messages.new(name)
                json_format.ParseDict(messages.to_dict(message), other)
                self.assertEqual(other, message)


class Values(Case):
    def test_both_spellings_of_a_name(self):
        for name in ("colorBy", "color_by"):
            self.assertEqual(messages.to_message("Layer", {name: {"column": "x"}}).color_by.column, "x")
        self.assertEqual(list(messages.to_message("Selection", {"not": {"ids": [1]}}).negated.ids), [1])

    def test_numpy_is_as_good_as_lists(self):
        made = messages.to_message("Selection", {
            "ids": np.array([1, 2**64 - 1], np.uint64), "density": {"max": np.float32(0.5)}, "step": np.int64(3),
            "polygon": {"columns": np.array(["x", "px"]), "points": np.array([[0, 1], [2, 3], [4, 5.5]])}})
        self.assertEqual(list(made.ids), [1, 2**64 - 1])
        self.assertEqual(made.step, 3)
        self.assertEqual([[v.number_value for v in p.values] for p in made.polygon.points], [[0, 1], [2, 3], [4, 5.5]])
        self.assertTrue(messages.to_message("Annotations", {"axes": np.bool_(True)}).axes)

    def test_nothing_is_left_out(self):
        self.assertFalse(messages.to_message("Layer", {"select": None}).HasField("select"))
        self.assertTrue(messages.to_message("Layer", {"select": {}}).HasField("select"))

    def test_what_is_wrong_is_named(self):
        cases = (
            ({"layers": [{}, {"foo": 1}]}, "v.layers[1]", "'foo'"),
            ({"layers": [{"select": {"ranges": [{"column": "x", "min": "a"}]}}]}, "v.layers[0].select.ranges[0].min", "number"),
            ({"layers": [{"select": {"ranges": [{"min": float("nan")}]}}]}, "v.layers[0].select.ranges[0].min", "NaN"),
            ({"width": -1}, "v.width", "from 0 to 4294967295"), ({"width": 2**32}, "v.width", ""),
            ({"width": 1.5}, "v.width", "whole"), ({"width": True}, "v.width", "whole"), ({"width": [1]}, "v.width", "list"),
            ({"camera": 3}, "v.camera", "mapping"), ({"layers": {"a": 1}}, "v.layers", "list"),
            ({"layers": "ab"}, "v.layers", "list"), ({"layers": [{"mesh": {}, "ink": {}}]}, "v.layers[0]", "both"),
            ({"layers": [{"dataset": b"x"}]}, "v.layers[0].dataset", "text"),
            ({"annotations": {"axes": 1}}, "v.annotations.axes", "True or False"),
            ({"background": [0, "1", 0]}, "v.background[1]", "number"),
            ({"selections": [{"selection": {"polygon": {"points": [[0, 1], 5]}}}]}, "v.selections[0].selection.polygon.points[1]",
             "list"))
        for value, where, words in cases:
            with self.subTest(where), self.fails("invalid_argument", where, words):
                messages.to_message("View", value, "v")
        with self.fails("invalid_argument", "p.format", "SVG"):
            messages.to_message("Page", {"format": "bmp"}, "p")

    def test_enumerators_have_names(self):
        self.assertEqual(messages.to_message("Page", {"format": "svg"}).format, 1)
        self.assertEqual(messages.to_dict(messages.to_message("Page", {"format": "PDF"})), {"format": "PDF"})


if __name__ == "__main__":
    unittest.main()
