# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person does with layers and datasets in mote-view, as desk_test.py; docs/VIEWER.md numbers it."""
import json
import math
import subprocess
import unittest

import numpy

import hand
from desk_case import PANEL, DeskCase, data, warm


class Layers(DeskCase):
    # Layers.

    def add(self, viewer, name):
        viewer.press("Add...")
        viewer.press(name, within=self.LIST)

    def test_15_a_layer_is_added(self):
        viewer = self.beam()
        self.add(viewer, "data/magnet")
        viewer.shows(lambda view: "mesh" in view["layers"][1])
        viewer.see("Mesh")  # its editor

    def test_16_the_eye_hides_and_shows_a_layer(self):
        viewer = self.beam()
        x, y = viewer.see("data/beam  particles")
        viewer.click(PANEL + 18, y)
        viewer.shows(lambda view: view["layers"][0]["hidden"] and "opacity" not in view["layers"][0])
        viewer.until(lambda: warm(viewer.picture()[:600, :840]).sum() < 50, "an empty picture")
        viewer.click(PANEL + 18, y)
        viewer.until(lambda: warm(viewer.picture()[:600, :840]).sum() > 2000, "the beam")

    def test_86_a_layer_gets_a_name(self):
        viewer = self.beam()
        x, y = viewer.see("layer's name")
        viewer.click(x - 120, y)
        viewer.type("halo")
        viewer.see("halo  particles")
        viewer.shows(lambda view: view["layers"][0]["name"] == "halo")
        viewer.key("Escape")
        viewer.click(x - 120, y)
        viewer.key("ctrl+a")
        viewer.key("BackSpace")
        viewer.see("data/beam  particles")

    def test_92_names_have_letters_of_other_scripts(self):
        name = "Пучок αβγ"
        path = self.saved("names.json", {"layers": [{"dataset": "data/beam", "name": name, "particles": {}}]})
        viewer = self.beam("--view", path)
        viewer.see(name, within=(PANEL, 300, 1280, 400), least=0.85)

    def test_88_depth_contrast_of_two_layers(self):
        viewer = self.beam()
        self.add(viewer, "data/magnet")
        viewer.wheel(1100, 600, -8)
        x, y = viewer.see("depth contrast")
        viewer.drag((x - 220, y), (x - 120, y), steps=6)
        viewer.shows(lambda view: 0.2 < view.get("depthContrast", 0) <= 1)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: "depthContrast" not in view)

    def test_17_layers_change_places_by_dragging(self):
        viewer = self.beam()
        self.add(viewer, "data/ct")
        begin = viewer.see("data/ct  hybrid")
        end = viewer.see("data/beam  particles")
        self.assertLess(begin[1], end[1])  # the upper one is over the others
        viewer.drag(begin, end)
        viewer.shows(lambda view: [layer["dataset"] for layer in view["layers"]] == ["data/ct", "data/beam"])

    def test_18_a_layer_is_removed_and_comes_back(self):
        viewer = self.beam()
        self.add(viewer, "data/ct")
        viewer.shows(lambda view: len(view["layers"]) == 2)
        viewer.press("Remove")
        viewer.shows(lambda view: len(view["layers"]) == 1)
        viewer.key("ctrl+z")
        viewer.shows(lambda view: len(view["layers"]) == 2)

    def test_19_each_layer_has_its_editor(self):
        viewer = self.beam()
        self.add(viewer, "data/ct")
        viewer.press("Dataset")  # folded, the rest is to be seen
        viewer.see("own range of colours")
        viewer.key("Right")  # the beam's steps, for the volume has none
        viewer.shows(lambda view: view["layers"][0].get("step") == 1 and "step" not in view["layers"][1])
        viewer.press("data/beam  particles")
        viewer.see("Volume: opacity over log density")

    # Datasets.

    def test_67_a_dataset_is_found_as_one_types(self):
        viewer = self.beam()
        viewer.key("d")
        viewer.see("3 of 3", within=self.LIST)
        for typed, name in (("dip", "data/magnet"), ("hyb", "data/ct")):  # of a title, of a kind
            viewer.type(typed)
            viewer.see("1 of 3", within=self.LIST)
            viewer.see(name, within=self.LIST)
            viewer.key("ctrl+a")
        viewer.type("nothing")
        viewer.see("0 of 3", within=self.LIST)
        viewer.key("ctrl+a")
        viewer.type("dipole mesh")
        viewer.see("1 of 3", within=self.LIST)
        viewer.key("Return")
        viewer.until(lambda: viewer.desk() and viewer.desk()["subject"] == "data/magnet", "the surface")
        viewer.gone("1 of 3", within=self.LIST)

    def test_68_datasets_have_pictures_and_are_sorted(self):
        viewer = self.beam()
        viewer.press("Add...")
        names = ["data/beam", "data/ct", "data/magnet"]

        def pictures():
            """Of each row its picture's pixels, rows from above."""
            picture = viewer.picture().astype(int)
            return [picture[y - 20:y + 20, 14:90] for y in rows]

        rows = [viewer.see(name, within=self.LIST)[1] for name in names]
        viewer.see("Draw a dataset as well", within=self.LIST)
        self.assertEqual(rows, sorted(rows))
        seen = viewer.until(lambda: all(part.max(2).std() > 5 for part in pictures()) and pictures(), "the pictures")
        self.assertGreater(warm(seen[0]).sum(), 20)  # the beam
        self.assertTrue(all(numpy.abs(a - b).max() > 60 for a, b in zip(seen, seen[1:])))
        viewer.press("name", within=(90, 130, 300, rows[0] - 10))
        viewer.until(lambda: (viewer.where("data/beam", within=self.LIST) or (0, 0))[1] > rows[1], "the other order")
        viewer.press("data/ct", within=self.LIST, least=0.95)
        viewer.shows(lambda view: [layer["dataset"] for layer in view["layers"]] == ["data/beam", "data/ct"])

    # Curves, colours, styles.

    def test_48_a_new_knot_acts_where_it_is(self):
        viewer = self.beam()
        viewer.press("Layers")  # folded, the rest is to be seen
        x, y = viewer.see("Points: fraction over log density")
        viewer.click(1104, y + 60)
        curve = viewer.shows(lambda view: "curve" in view["layers"][0]["particles"].get("points", {}))
        knots = [(knot.get("density", 0), knot.get("fraction", 0)) for knot in curve["layers"][0]["particles"]["points"]["curve"]]
        self.assertEqual((knots[0][0], knots[-1][0]), (0, 1))
        self.assertEqual(knots[0][1], 1)
        self.assertTrue(any(abs(at - 0.5) < 0.05 and value < 0.9 for at, value in knots), knots)

    def test_49_a_knots_numbers_are_typed(self):
        viewer = self.beam()
        viewer.press("Layers")  # folded, the rest is to be seen
        viewer.press("Dataset")
        x, y = viewer.see("Points: fraction over log density")
        viewer.click(1104, y + 60)
        viewer.move(400, 650)
        viewer.gone("fraction", within=(1100, y + 20, 1280, y + 100))  # at the pointer
        x, y = viewer.see("fraction", within=(1100, y + 100, 1280, 720))
        viewer.click(x - 60, y)
        viewer.key("ctrl+a")
        viewer.type("0.125")
        viewer.key("Return")
        viewer.shows(lambda view: any(knot.get("fraction") == 0.125 for knot in view["layers"][0]["particles"]["points"]["curve"]))

    def test_50_a_colour_map_is_chosen_by_its_colours(self):
        viewer = self.beam()
        viewer.press("Dataset")  # folded, the rest is to be seen
        viewer.press("inferno", within=(PANEL, 400, 1160, 690))
        viewer.press("viridis")
        viewer.shows(lambda view: view["layers"][0]["particles"]["volume"]["colorMap"] == "viridis")

    def test_51_a_style_is_copied_to_another_layer(self):
        viewer = self.beam()
        viewer.press("Dataset")  # folded, the rest is to be seen
        viewer.press("Duplicate")
        viewer.shows(lambda view: len(view.get("layers", ())) == 2)
        viewer.press("inferno", within=(PANEL, 400, 1160, 720))
        viewer.press("viridis")
        viewer.shows(lambda view: view["layers"][1]["particles"]["volume"]["colorMap"] == "viridis")
        viewer.do("Copy style")
        viewer.press("data/beam  particles", nth=1)
        viewer.do("Paste style")
        viewer.shows(lambda view: view["layers"][0]["particles"]["volume"]["colorMap"] == "viridis")

    def test_52_a_style_is_saved_and_opened(self):
        viewer = self.beam()
        viewer.press("Dataset")  # folded, the rest is to be seen
        viewer.press("inferno", within=(PANEL, 400, 1160, 690))
        viewer.press("viridis")
        viewer.shows(lambda view: view["layers"][0]["particles"]["volume"]["colorMap"] == "viridis")
        viewer.do("Save style...")
        viewer.see("Cancel")
        viewer.key("Return")
        path = viewer.folder / "style.json"
        viewer.until(path.exists, "the file")
        viewer.gone("Cancel")
        viewer.key("ctrl+z")
        viewer.shows(lambda view: view["layers"][0]["particles"]["volume"]["colorMap"] == "inferno")
        viewer.do("Open style...")
        viewer.see("Cancel")
        viewer.key("Return")
        viewer.shows(lambda view: view["layers"][0]["particles"]["volume"]["colorMap"] == "viridis")

    def test_89_curves_are_a_presets_and_the_plots_own_again(self):
        viewer = self.beam()
        viewer.press("Layers")  # folded, the rest is to be seen
        viewer.press("choose curves")
        viewer.press("all as points")
        points = viewer.shows(lambda view: "curve" in view["layers"][0]["particles"].get("points", {}))
        style = points["layers"][0]["particles"]
        self.assertEqual([knot.get("opacity", 0) for knot in style["volume"]["curve"]], [0, 0])
        self.assertEqual([knot["fraction"] for knot in style["points"]["curve"]], [1, 1])
        viewer.press("choose curves")
        viewer.press("the plot's own")
        viewer.shows(lambda view: "curve" not in view["layers"][0]["particles"].get("points", {}))

    def test_90_densities_have_a_range_of_their_own(self):
        viewer = self.beam()
        viewer.press("Layers")  # folded, the rest is to be seen
        viewer.press("Dataset")
        viewer.press("own range of densities")
        view = viewer.shows(lambda view: len(view["layers"][0]["particles"].get("volume", {}).get("densityRange", ())) == 2)
        low, high = view["layers"][0]["particles"]["volume"]["densityRange"]
        facts = json.loads(subprocess.run([hand.BIN / "mote-prep", "info", data() / "beam.mote", "--json"],
                                          check=True, capture_output=True).stdout)["particles"]
        box = math.prod(axis["max"] - axis["min"] for axis in facts["axes"])
        self.assertAlmostEqual(low * box / facts["densityMin"], 1, places=6)
        self.assertAlmostEqual(high * box / facts["densityMax"], 1, places=6)
        x, y = viewer.see("least density", within=(1100, 100, 1280, 720))
        viewer.click(x - 100, y)
        viewer.key("ctrl+a")
        viewer.type(f"{2 * low:.6g}")
        viewer.key("Return")
        viewer.shows(lambda view: abs(view["layers"][0]["particles"]["volume"]["densityRange"][0] / (2 * low) - 1) < 1e-4)

    # Cut and placed by hand: a unit is 172 pixels, the middle of all stands at 470, 344.

    def straight(self, **layer):
        """The beam from the front, without perspective."""
        path = self.saved("straight.json", {
            "camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "orthographicHeight": 4},
            "layers": [{"dataset": "data/beam", "particles": {}, **layer}]})
        return self.beam("--view", path)

    @staticmethod
    def at(x, y, right=0, down=0):
        return 470 + 172 * x + right, 344 - 172 * y + down

    def columns(self, viewer):
        return numpy.nonzero(warm(viewer.picture()[:600, :PANEL]).any(0))[0]

    def test_62_a_face_of_the_box_is_dragged(self):
        viewer = self.straight()
        end = self.columns(viewer).max()
        self.assertGreater(end, self.at(0.4, 0)[0])
        viewer.key("c")
        viewer.drag(self.at(1, 0), self.at(0.25, 0), steps=12)
        box = viewer.shows(lambda view: "clip" in view["layers"][0])["layers"][0]["clip"]["box"]
        numpy.testing.assert_allclose(box["max"], [0.25, 1, 1], atol=0.02)
        self.assertEqual(box["min"], [-1, -1, -1])
        viewer.key("c")  # handles are warm too
        viewer.until(lambda: abs(self.columns(viewer).max() - self.at(0.25, 0)[0]) < 6, "the cut")
        viewer.key("ctrl+z")  # one gesture
        viewer.shows(lambda view: "clip" not in view["layers"][0])
        viewer.until(lambda: abs(self.columns(viewer).max() - end) < 3, "all of it")

    def test_63_a_plane_is_dragged_and_turned(self):
        viewer = self.straight(clip={"planes": [{"normal": [2, 0, 0], "distance": 0}]})
        plane = lambda view: view["layers"][0]["clip"]["planes"][0]
        viewer.key("c")
        viewer.drag(self.at(0, 0), self.at(0.5, 0), steps=12)
        viewer.shows(lambda view: abs(plane(view).get("distance", 0) - 1) < 0.05)  # the normal is 2 long
        viewer.drag(self.at(0.5, 0, right=70), self.at(0.5, 0, down=-70))
        view = viewer.shows(lambda view: abs(plane(view)["normal"][1] - 2) < 0.05)
        self.assertLess(abs(plane(view)["normal"][0]) + abs(plane(view).get("distance", 0)), 0.1)
        viewer.key("c")
        viewer.until(lambda: not warm(viewer.picture()[352:600, :PANEL]).any(), "the lower half's end")
        viewer.key("ctrl+z")
        viewer.key("ctrl+z")
        viewer.shows(lambda view: plane(view).get("distance", 0) == 0 and plane(view)["normal"] == [2, 0, 0])

    def test_64_cut_by_numbers(self):
        viewer = self.beam()
        viewer.move(1100, 500)
        viewer.key("c")  # unfolds it
        viewer.wheel(1100, 600, -8)
        viewer.press("Cut in front of the middle")
        viewer.shows(lambda view: len(view["layers"][0]["clip"]["planes"]) == 1)
        before = viewer.view()["layers"][0]["clip"]["planes"][0]
        viewer.press("Other side")
        viewer.shows(lambda view: view["layers"][0]["clip"]["planes"][0]["normal"] == [-n for n in before["normal"]])
        viewer.press("box", within=(PANEL, 0, 1150, 720))
        viewer.shows(lambda view: view["layers"][0]["clip"].get("box", {}).get("min") == [-1, -1, -1])
        viewer.press("Remove plane")
        viewer.shows(lambda view: "planes" not in view["layers"][0]["clip"])

    def test_65_a_layer_is_shifted_turned_and_stretched(self):
        viewer = self.straight()
        begin = self.columns(viewer).min()
        moved = lambda view: numpy.reshape(view["layers"][0]["transform"], (4, 4))
        viewer.key("g")
        viewer.drag(self.at(0, 0, right=90), self.at(0.5, 0, right=90))
        view = viewer.shows(lambda view: abs(view["layers"][0].get("transform", [0] * 4)[3] - 0.5) < 0.02)
        numpy.testing.assert_allclose(moved(view)[:, :3], numpy.eye(4)[:, :3])
        viewer.key("g")
        viewer.until(lambda: abs(self.columns(viewer).min() - begin - 86) < 6, "the shift")
        viewer.key("g")
        viewer.key("ctrl+z")
        viewer.shows(lambda view: "transform" not in view["layers"][0])
        viewer.drag(self.at(0, 0, 44, -44), self.at(0, 0, -44, -44))
        view = viewer.shows(lambda view: "transform" in view["layers"][0])
        numpy.testing.assert_allclose(moved(view)[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=0.03)
        viewer.drag(self.at(0, 0, 78, -78), self.at(0, 0, 156, -156))
        view = viewer.shows(lambda view: numpy.abs(moved(view)).max() > 1.5)
        numpy.testing.assert_allclose(moved(view)[:3, :3], [[0, -2, 0], [2, 0, 0], [0, 0, 2]], atol=0.1)
        viewer.key("ctrl+z")
        viewer.key("ctrl+z")
        viewer.shows(lambda view: "transform" not in view["layers"][0])

    def test_66_a_place_is_typed(self):
        viewer = self.beam()
        viewer.key("g")
        viewer.move(1100, 500)
        viewer.wheel(1100, 600, -8)
        for what, number, place in (("shift", "0.25", 3), ("stretch", "2", 0)):
            x, y = viewer.see(what, within=(1150, 0, 1280, 720))
            viewer.click(x - 210, y)
            viewer.key("ctrl+a")
            viewer.type(number)
            viewer.key("Return")
            viewer.shows(lambda view: view["layers"][0].get("transform", [0] * 16)[place] == float(number))
        viewer.press("Back to its own place")
        viewer.shows(lambda view: "transform" not in view["layers"][0])


if __name__ == "__main__":
    unittest.main()
