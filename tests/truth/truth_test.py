# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of particles held against the particles: of generated sets, at several sizes and zooms, with weights."""
import os
import pathlib
import sys
import tempfile
import unittest

import numpy
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import data  # noqa: E402
import truth  # noqa: E402

BIN = os.environ["MOTE_BIN"]


def linear16(picture):
    """Linear red, green and blue of a picture of 16 bits."""
    reader = vtkPNGReader()
    reader.SetFileName(str(picture))
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    encoded = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[..., :3] / 65535.0
    return numpy.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


class TruthCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.plots = truth.Plots(cls.folder.name, BIN)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()


class Matter(TruthCase):
    """What the default style shows, and the measures themselves."""

    def test_sets_that_nobody_chose(self):
        for name, count, drawn, points in truth.hold(self.plots, range(28, 42), 100_000, "cpu"):
            with self.subTest(name, count=count):
                # As all points, each of which is drawn: the picture leaves nothing out.
                self.assertLessEqual(drawn["black"], points["black"] + 0.01)
                self.assertGreaterEqual(drawn["rank"], points["rank"] - 0.1)

    def test_what_is_thin_is_seen(self):
        random = numpy.random.default_rng(5)
        y = 0.4 * random.normal(size=200_000)
        band = numpy.c_[random.normal(size=len(y)), y, y]
        inside = self.plots.add("band", band, numpy.ones(len(y)))
        weight = truth.weight_map(inside, numpy.ones(len(y)))
        found = truth.measure(weight, self.plots.draw([truth.view("band")], "band")[0])
        self.assertLessEqual(found["black"], 0.01)
        self.assertGreaterEqual(found["rank"], 0.85)

    def test_an_even_gas_is_as_even_as_chance_lets_it(self):
        random = numpy.random.default_rng(3)
        camera = {"eye": [0, 0, 6], "target": [0, 0, 0], "up": [0, 1, 0], "orthographicHeight": 1.6}
        for count in (10_000, 100_000, 1_000_000):  # the last one is a volume, too
            self.plots.add(f"gas{count}", random.uniform(-1, 1, (count, 3)), numpy.ones(count))
            picture, = self.plots.draw([truth.view(f"gas{count}", None, (360, 360), camera)], f"gas{count}")
            light, _ = truth.light_map(picture)
            for edge in (9, 27):
                patches = truth.mean(light, edge)[edge:-edge:edge, edge:-edge:edge]
                counted = count * (edge / 360 * 1.6 / 2) ** 2  # particles of a patch
                with self.subTest(count=count, edge=edge):
                    self.assertLess(patches.std() / patches.mean(), 1.3 / counted ** 0.5)

    def test_a_measure_fails_where_matter_is_missing(self):
        random = numpy.random.default_rng(6)
        inside = self.plots.add("gas", random.uniform(-1, 1, (50_000, 3)), numpy.ones(50_000))
        weight = truth.weight_map(inside, numpy.ones(len(inside)))
        half = {"points": {"linked": False, "curve": [{"density": 0, "fraction": 0.3}]},
                "volume": {"curve": [{"density": 0, "opacity": 0}]}}
        pictures = self.plots.draw([truth.view("gas"), truth.view("gas", half)], "half")
        whole, missing = (truth.measure(weight, picture) for picture in pictures)
        self.assertLess(whole["black"], 0.01)
        self.assertGreater(missing["black"], 0.4)


class SizeAndZoom(TruthCase):
    """The light of a part of the picture does not depend on how large or how near it is seen."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        random = numpy.random.default_rng(7)
        core = 0.02 * random.normal(size=(150_000, 3))
        halo = random.uniform(-1, 1, (20_000, 3))
        cls.plots.add("beam", numpy.concatenate([core, halo]), numpy.ones(170_000))

    def mean_lights(self, views, out):
        return [truth.light_map(picture)[0].mean() for picture in self.plots.draw(views, out)]

    def test_sizes(self):
        sizes = [(640, 360), (1280, 720), (2560, 1440)]
        lights = self.mean_lights([truth.view("beam", size=size) for size in sizes], "sizes")
        for light in lights[1:]:
            self.assertAlmostEqual(light / lights[0], 1.0, delta=0.15)

    def test_zooms(self):
        # Of the halo beside the core: the same light in any part of it, from the whole to a sixteenth.
        views = []
        for zoom in (1, 4, 16):
            camera = {"eye": [0.5, 0.5, 6], "target": [0.5, 0.5, 0], "up": [0, 1, 0], "orthographicHeight": 0.8 / zoom}
            views.append(truth.view("beam", size=(640, 640), camera=camera))
        lights = self.mean_lights(views, "zooms")
        # A 256th of 3,200 particles in view are 13 at the least: counting leaves a fourth of that to chance.
        self.assertAlmostEqual(lights[1] / lights[0], 1.0, delta=0.2)
        self.assertAlmostEqual(lights[2] / lights[0], 1.0, delta=0.8)


class Weights(TruthCase):
    """Optical depths: what a plot over grey less the same over black lets through; both are dark to the defaults."""

    GREY = 0.4, ((0.4 + 0.055) / 1.055) ** 2.4  # sRGB, linear

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.random = numpy.random.default_rng(8)
        cls.places = cls.random.uniform(-1, 1, (200_000, 3))

    def optical_depth(self, name, weight, style=truth.POINTS):
        self.plots.add(name, self.places, weight)
        camera = {"eye": [0, 0, 6], "target": [0, 0, 0], "up": [0, 1, 0], "orthographicHeight": 2.0}
        views = [truth.view(name, style, (160, 160), camera, background=[shade] * 3) for shade in (0, self.GREY[0])]
        black, grey = (linear16(picture) for picture in self.plots.draw(views, name, form="png16"))
        return -numpy.log((grey - black).mean(axis=2) / self.GREY[1])

    def test_a_hundredfold_weight_hides_a_hundredfold(self):
        weight = numpy.where(self.places[:, 0] < 0, 1.0, 100.0)
        for name, style in (("points", truth.POINTS), ("default", None)):
            depth = self.optical_depth(name, weight, style)
            self.assertAlmostEqual(depth[:, 90:150].mean() / depth[:, 10:70].mean(), 100.0, delta=5.0)

    def test_a_mixture_hides_what_its_weights_do_together(self):
        weight = numpy.where(self.random.random(len(self.places)) < 0.5, 1.0, 100.0)
        mixed = self.optical_depth("mixed", weight)
        even = self.optical_depth("even", numpy.full(len(weight), weight.mean()))
        self.assertAlmostEqual(mixed.mean() / even.mean(), 1.0, delta=0.01)


class Colours(TruthCase):
    """Points and volume speak of one column, and outliers do not own its colours."""

    def test_the_column_is_told_by_the_colour_everywhere(self):
        random = numpy.random.default_rng(9)
        places = numpy.concatenate([random.normal(size=(150_000, 3)) * [0.3, 0.1, 0.1],
                                    random.uniform(-1, 1, (20_000, 3))])
        places[:50, 0] = 4.0  # far from all others
        self.plots.add("column", places, numpy.ones(len(places)), "x")
        camera = {"eye": [0, 0, 6], "target": [0, 0, 0], "up": [0, 1, 0], "orthographicHeight": 2.0}
        shown = truth.view("column", None, (800, 400), camera)
        shown["layers"][0]["colorBy"] = {"column": "x"}
        whole = numpy.asarray(Image.open(self.plots.draw([shown], "column")[0]).convert("RGB")) / 255.0
        linear = numpy.where(whole <= 0.04045, whole / 12.92, ((whole + 0.055) / 1.055) ** 2.4)
        lit = linear.sum(axis=2) > 0.02
        # Of viridis green over green and blue grows with the value, whatever hides how much of it.
        share = linear[..., 1] / numpy.maximum(linear[..., 1] + linear[..., 2], 1e-9)
        columns = numpy.broadcast_to(numpy.arange(800), lit.shape)
        self.assertGreater(lit.sum(), 5000)
        self.assertGreater(truth.rank_correlation(columns[lit], share[lit]), 0.9)
        # From side to side of the dense core, which is volume, most of the map is gone through.
        core = lit & (abs(numpy.arange(400)[:, None] - 200) < 5)
        self.assertLess(share[core].min(), 0.2)
        self.assertGreater(share[core].max(), 0.8)


if __name__ == "__main__":
    unittest.main()
