"""Renders a Scene with LuxCore (pyluxcore), whose noise training never sees, for tests.

Uses the CPU path tracer without clamping, adaptive sampling, denoising or tone mapping, and with independent random
numbers (LuxCore's RANDOM sampler). The color is linear radiance, the albedo LuxCore's own, the normal the world-space
shading normal. Albedo and normal follow mirrors and glass and, as is LuxCore's default, include the objects that smooth
plastic reflects or is lit by; they are 0 where nothing is hit. Renders every feature of a Scene, but the camera does
not see point lights.

LuxCore's path tracer does not splat: it draws a sample's position from the filter and adds the sample to one pixel
only, so neighboring pixels have independent noise with either filter. "narrow" is a one-pixel box; "gaussian" is
LuxCore's default, a Blackman-Harris filter of radius 1.5 pixels, which only softens the image.
"""

import atexit
import time
from importlib.machinery import PathFinder
from importlib.util import find_spec, module_from_spec

import numpy as np

from .scene import Camera, Instance, Material, PointLight, Scene

MAX_DEPTH = 8
FILTERS = {"narrow": "NONE", "gaussian": "BLACKMANHARRIS"}
LEAF = 0.4  # share of light that a leaf transmits
CLEAR = 0.03  # roughness up to which glass and metal count as perfectly smooth
PAUSE = 4e6  # samples outside the image, which the sampler takes at least 0.1 s to skip


def load():
    """Loads the library without its Python wrapper, which prints what it loads and installs a global allocator that
    crashes later imports."""
    package = find_spec("pyluxcore")
    if package is None:
        raise SystemExit("LuxCore is missing: pip install pyluxcore")
    spec = PathFinder.find_spec("pyluxcore", package.submodule_search_locations)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


pyluxcore = load()
pyluxcore.Init(lambda message: None)
atexit.register(pyluxcore.SetLogHandler, None)  # LuxCore logs its shutdown after Python has ended


def properties(prefix: str, values: dict):
    """Settings in LuxCore's form, which accepts only plain numbers, strings and lists."""
    result = pyluxcore.Properties()
    for name, value in values.items():
        result.Set(pyluxcore.Property(prefix + name, np.asarray(value).tolist()))
    return result


def box(half: float) -> tuple[list, list]:
    """Vertices and outward faces of a cube around the origin."""
    corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [triangle for a, b, c, d in sides for triangle in ((a, b, c), (a, c, d))]


def count(session) -> int:
    """The number of samples taken."""
    return int(session.GetFilm().GetStats().Get("stats.film.total.samplecount").GetFloat())


class Renderer:
    """A Scene, ready to render from each of its cameras."""

    name = "luxcore"

    def __init__(self, scene: Scene, size: tuple[int, int], threads: int, pixel_filter: str = "narrow"):
        self.cameras, self.size, self.threads = scene.cameras, size, threads
        self.filter = FILTERS[pixel_filter]
        self.scene = pyluxcore.Scene()
        self.names = {}  # of the meshes, materials and images already given to LuxCore, by id
        self.air = {"volume": "fog"} if scene.fog else {}  # volume around the cameras
        if scene.fog:
            self.add_fog(scene)
        self.set_camera(scene.cameras[0])
        for number, instance in enumerate(scene.instances):
            self.add_instance(f"object{number}", instance)
        for number, light in enumerate(scene.lights):
            self.add_light(f"light{number}", light)
        if scene.environment is not None:
            self.add_environment(scene.environment)

    def parse(self, prefix: str, values: dict):
        self.scene.Parse(properties(prefix, values))

    def named(self, thing, kind: str, add) -> str:
        """The LuxCore name of a part of the scene; `add` creates it at first use."""
        key = id(thing)
        if key not in self.names:
            self.names[key] = f"{kind}{len(self.names)}"
            add(self.names[key], thing)
        return self.names[key]

    def add_mesh(self, name: str, mesh):
        rows = [None if a is None else [tuple(row) for row in a.tolist()]
                for a in (mesh.vertices, mesh.faces, mesh.normals, mesh.uvs)]
        self.scene.DefineMesh(name, *rows, None, None)

    def add_image(self, name: str, image: np.ndarray):
        height, width, channels = np.atleast_3d(image).shape
        self.scene.DefineImageMap(name, np.ascontiguousarray(image, np.float32), 1.0, channels, width, height)

    def add_material(self, name: str, material: Material):
        color = material.color
        if material.texture is not None:
            color = self.add_texture(f"{name}_color", material.texture)
        bump = {}
        if material.bump is not None:
            bump = {"bumptex": self.add_texture(f"{name}_bump", material.bump)}
        self.parse(f"scene.materials.{name}.", self.surface(name, material, color) | bump)

    def add_texture(self, name: str, pixels: np.ndarray) -> str:
        """Names a texture of the image; LuxCore's v runs down it."""
        image = self.named(pixels, "image", self.add_image)
        self.parse(f"scene.textures.{name}.", {"type": "imagemap", "file": image, "gamma": 1.0,
                                               "mapping.type": "uvmapping2d", "mapping.uvscale": (1.0, -1.0),
                                               "mapping.uvdelta": (0.0, 1.0)})
        return name

    def surface(self, name: str, material: Material, color) -> dict:
        """The settings of a material. LuxCore's roughness is the microfacet width, the square of ours."""
        width = max(material.roughness, 0.03) ** 2
        rough = {"uroughness": width, "vroughness": width}
        if material.emission is not None:
            return {"type": "matte", "kd": (0.0, 0.0, 0.0), "emission": material.emission}
        if material.kind == "diffuse":
            return {"type": "matte", "kd": color}
        if material.kind == "plastic":
            gloss = ((material.ior - 1) / (material.ior + 1)) ** 2
            return {"type": "glossy2", "kd": color, "ks": (gloss,) * 3, **rough}
        if material.kind == "metal":
            return self.metal(name, color, rough if material.roughness > CLEAR else None)
        if material.kind == "glass":
            tint = tuple(np.sqrt(material.color))  # light passes two surfaces of an object, so each takes the root
            kind = {"type": "roughglass", **rough} if material.roughness > CLEAR else {"type": "glass"}
            return {**kind, "kr": (1.0, 1.0, 1.0), "kt": tint, "interiorior": material.ior, "exteriorior": 1.0}
        if material.kind == "thin_leaf":
            return self.thin_leaf(name, color)
        raise SystemExit(f"LuxCore: unknown material kind {material.kind!r}")

    def metal(self, name: str, color, rough: dict | None) -> dict:
        if rough is None:
            return {"type": "mirror", "kr": color}
        self.parse(f"scene.textures.{name}_fresnel.", {"type": "fresnelcolor", "kr": color})
        return {"type": "metal2", "fresnel": f"{name}_fresnel", **rough}

    def thin_leaf(self, name: str, color) -> dict:
        """Transmits LEAF of the light. LuxCore's `kt` is a share of the light that is not reflected, hence the
        division."""
        texture = f"scene.textures.{name}_"
        self.parse(texture + "back.", {"type": "scale", "texture1": color, "texture2": 1 - LEAF})
        self.parse(texture + "rest.", {"type": "subtract", "texture1": 1.0, "texture2": f"{name}_back"})
        self.parse(texture + "part.", {"type": "scale", "texture1": color, "texture2": LEAF})
        self.parse(texture + "through.", {"type": "divide", "texture1": f"{name}_part", "texture2": f"{name}_rest"})
        return {"type": "mattetranslucent", "kr": f"{name}_back", "kt": f"{name}_through"}

    def add_instance(self, name: str, instance: Instance):
        values = {"shape": self.named(instance.mesh, "mesh", self.add_mesh),
                  "material": self.named(instance.material, "material", self.add_material)}
        columns = np.array(instance.matrix, float).T.ravel()  # the last is the position
        if instance.motion is None:
            values["transformation"] = columns
        else:
            moved = columns.copy()
            moved[12:15] += instance.motion
            values.update({"motion.0.time": 0.0, "motion.0.transformation": columns,
                           "motion.1.time": 1.0, "motion.1.transformation": moved})
        self.parse(f"scene.objects.{name}.", values)

    def add_light(self, name: str, light: PointLight):
        gain = 4 * np.pi * np.asarray(light.power, float)  # LuxCore spreads it over all directions
        self.parse(f"scene.lights.{name}.", {"type": "sphere", "position": tuple(light.position),
                                             "radius": light.radius, "gain": gain})

    def add_environment(self, image: np.ndarray):
        """Adds the environment map, flipped: seen from above, Blender's columns run clockwise from -x, LuxCore's
        counterclockwise from x."""
        self.add_image("environment", np.roll(image[:, ::-1], image.shape[1] // 2, 1))
        self.parse("scene.lights.environment.", {"type": "infinite", "file": "environment", "gamma": 1.0})

    def add_fog(self, scene: Scene):
        """Adds fog in a box around the scene; if it filled the world, it would block the environment's light."""
        self.parse("scene.volumes.fog.", {"type": "homogeneous", "absorption": (0.1 * scene.fog,) * 3,
                                          "scattering": (0.9 * scene.fog,) * 3, "multiscattering": True})
        self.parse("scene.materials.fog_skin.", {"type": "null", "volume.interior": "fog"})
        self.scene.DefineMesh("fog", *box(1.5 * scene.reach()), None, None, None, None)
        self.parse("scene.objects.fog.", {"shape": "fog", "material": "fog_skin"})

    def set_camera(self, camera: Camera):
        """Sets the camera. The screen window follows the longer side, and so does the field of view."""
        x, y = np.array(self.size, float) / max(self.size)
        plumb = tuple(camera.position[:2]) == tuple(camera.target[:2])
        self.parse("scene.camera.", {
            "type": "perspective", "lookat.orig": tuple(camera.position), "lookat.target": tuple(camera.target),
            "up": (0.0, 1.0, 0.0) if plumb else (0.0, 0.0, 1.0), "fieldofview": camera.fov,
            "screenwindow": (-x, x, -y, y), "autofocus.enable": False, "lensradius": camera.aperture,
            "focaldistance": camera.focus, "shutteropen": 0.0, "shutterclose": 1.0, "autovolume.enable": False,
            **self.air})

    def settings(self, samples: int, seed: int) -> dict:
        """The render settings. `tilesize` makes the sampler pause after `samples` samples of each pixel (see
        `trace`)."""
        width, height = self.size
        tile = 2 ** int(np.ceil(np.log2(max(width, height, (width * height + PAUSE / samples) ** 0.5))))
        outputs = {f"film.outputs.{i}.{key}": value for i, kind in enumerate(("RGB", "ALBEDO", "AVG_SHADING_NORMAL"))
                   for key, value in (("type", kind), ("filename", f"{kind}.exr"))}
        return {"renderengine.type": "PATHCPU",
                "renderengine.seed": 1 + seed * self.threads % 2**31,  # each thread adds its index
                "native.threads.count": self.threads, "sampler.type": "RANDOM", "sampler.random.adaptive.strength": 0.0,
                "sampler.random.tilesize": tile, "sampler.random.supersampling": samples,
                **{f"path.pathdepth.{kind}": MAX_DEPTH for kind in ("total", "diffuse", "glossy", "specular")},
                "path.clamping.variance.maxvalue": 0.0, "film.filter.type": self.filter, "film.width": width,
                "film.height": height, **outputs}

    def trace(self, samples: int, seed: int):
        """A session that has taken exactly `samples` samples of each pixel. LuxCore cannot stop at an exact number by
        itself. But its sampler takes all samples of a pixel at once, walking over a square that starts with the image
        and extends beyond it. While it skips the rest of the square, we stop it."""
        total = samples * self.size[0] * self.size[1]
        while True:
            config = pyluxcore.RenderConfig(properties("", self.settings(samples, seed)), self.scene)
            session = pyluxcore.RenderSession(config)
            session.Start()
            while count(session) < total:
                time.sleep(0.005)
            session.Stop()
            if count(session) == total:  # otherwise this process slept too long and the next pass began
                return session

    def render(self, camera: int, samples: int, seed: int) -> np.ndarray:
        """float32 [9,H,W]: linear color, albedo, shading normal in world space."""
        self.set_camera(self.cameras[camera])
        session = self.trace(samples, seed)
        kinds = pyluxcore.FilmOutputType
        layers = []
        for kind in (kinds.RGB, kinds.ALBEDO, kinds.AVG_SHADING_NORMAL):
            layer = np.zeros((self.size[1], self.size[0], 3), np.float32)
            session.GetFilm().GetOutputFloat(kind, layer, 0)
            layers.append(layer[::-1].transpose(2, 0, 1))  # LuxCore's first row is the bottom one
        return np.ascontiguousarray(np.concatenate(layers))
