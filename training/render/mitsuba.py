"""Renders a Scene with Mitsuba 3, on an NVIDIA GPU if available, else on the CPU, which needs libLLVM 16 or newer (set
DRJIT_LIBLLVM_PATH to the file).

Normals are in world space. Mitsuba 3 lacks motion blur: objects stay where they are when the shutter opens. Compared
to the other two renderers, environments are rotated by 90 degrees and textures are upside down.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from . import meshes

mi.set_variant("cuda_ad_rgb", "llvm_ad_rgb")
T = mi.ScalarTransform4f
WAVE = 1 << 20  # paths traced at once; a few hundred bytes each


class Renderer:
    name = "mitsuba"

    def __init__(self, scene, size, threads, pixel_filter="narrow"):
        dr.set_thread_count(threads)
        self.size, self.fog = size, scene.fog
        self.filter = "box" if pixel_filter == "narrow" else "gaussian"
        parts = dict(type="scene", integrator=_integrator(scene.fog))
        parts.update((f"mesh{i}", shape) for i, shape in enumerate(_shapes(scene.instances)))
        parts.update((f"light{i}", _lamp(light)) for i, light in enumerate(scene.lights))
        if scene.environment is not None:
            turned = T().rotate([1, 0, 0], 90)
            parts["sky"] = dict(type="envmap", bitmap=mi.Bitmap(scene.environment), to_world=turned)
        medium = None
        if scene.fog:
            medium = mi.load_dict(dict(type="homogeneous", albedo=0.9, sigma_t=scene.fog))
            parts["fog"] = _fog_bounds(scene, medium)
        self.scene = mi.load_dict(parts)
        self.sensors = [self._sensor(camera, medium) for camera in scene.cameras]

    def _sensor(self, camera, medium):
        up = [0, 0, 1] if camera.position[:2] != camera.target[:2] else [0, 1, 0]
        film = dict(type="hdrfilm", width=self.size[0], height=self.size[1], rfilter=dict(type=self.filter))
        sensor = dict(type="perspective", fov=camera.fov, fov_axis="larger", near_clip=1e-3, film=film,
                      to_world=T().look_at(list(camera.position), list(camera.target), up))
        if camera.aperture:
            sensor.update(type="thinlens", aperture_radius=camera.aperture, focus_distance=camera.focus)
        if medium:
            sensor["medium"] = medium
        return _variable(mi.load_dict(sensor))

    def render(self, camera, samples, seed):
        """Renders in passes of a fixed number of samples, so one kernel serves all sample counts."""
        most = max(1, WAVE // (self.size[0] * self.size[1]))
        total, done = 0, 0
        while done < samples:
            n = min(most, samples - done)
            image = mi.render(self.scene, sensor=self.sensors[camera], spp=n, seed=_mixed(seed, done))
            total, done = total + n * np.array(image, np.float64), done + n
        image = (total / samples).transpose(2, 0, 1)
        image[3:6] = np.clip(image[3:6], 0, 1)  # the albedo of a glossy surface may exceed 1
        return np.ascontiguousarray(image, np.float32)


def _mixed(seed, done):
    return int(np.random.SeedSequence([seed, done]).generate_state(1)[0])


def _variable(sensor):
    """The sensor with its lens as a runtime parameter, so one kernel serves all cameras."""
    parameters = mi.traverse(sensor)
    for name in ("aperture_radius", "focus_distance"):
        if name in parameters:
            parameters[name] = dr.opaque(mi.Float, parameters[name][0])
    parameters.update()
    return sensor


def _integrator(fog):
    light = dict(type="volpath" if fog else "path", max_depth=8, rr_depth=5)
    return dict(type="aov", aovs="albedo:albedo,normal:sh_normal", image=light)


def _shapes(instances):
    """One shape per material, as many shapes take long to compile."""
    groups = {}
    for i in instances:
        groups.setdefault(id(i.material), (i.material, []))[1].append(meshes.moved(i.mesh, i.matrix))
    return [_shape(meshes.merge(group), material) for material, group in groups.values()]


def _shape(mesh, material):
    bsdf = mi.load_dict(_bsdf(material))
    properties = mi.Properties()
    properties["bsdf"] = bsdf
    if material.emission is not None:
        properties["emitter"] = mi.load_dict(dict(type="area", radiance=_rgb(material.emission)))
    smooth, mapped = mesh.normals is not None, mesh.uvs is not None
    shape = mi.Mesh("mesh", len(mesh.vertices), len(mesh.faces), properties, smooth, mapped)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = mesh.vertices.ravel()
    parameters["faces"] = mesh.faces.ravel().astype(np.uint32)
    if smooth:
        parameters["vertex_normals"] = mesh.normals.ravel()
    if mapped:
        parameters["vertex_texcoords"] = mesh.uvs.ravel()
    parameters.update()
    return shape


def _bsdf(m):
    """The material as a Mitsuba plugin, with its bump map if it has one."""
    if m.bump is None:
        return _plain_bsdf(m)
    heights = dict(type="bitmap", bitmap=mi.Bitmap(m.bump[..., None]), raw=True)
    return dict(type="bumpmap", heights=heights, bsdf=_plain_bsdf(m))


def _plain_bsdf(m):
    """Rough materials use GGX with alpha = roughness squared, as is common."""
    alpha, rough = max(m.roughness, 0.03) ** 2, m.roughness > 0.03
    color = _rgb(m.color) if m.texture is None else dict(type="bitmap", bitmap=mi.Bitmap(m.texture), raw=True)
    if m.emission is not None:
        return dict(type="diffuse", reflectance=0.0)
    if m.kind == "glass":
        # light passes two surfaces of an object, so each takes the root of the color
        tint = _rgb(np.sqrt(m.color))
        glass = dict(int_ior=m.ior, specular_transmittance=tint)
        return dict(glass, type="roughdielectric", alpha=alpha) if rough else dict(glass, type="dielectric")
    if m.kind == "thin_leaf":
        return dict(type="principledthin", base_color=color, diff_trans=0.8, roughness=0.8, spec_trans=0.0)
    if m.kind == "metal":
        metal = dict(type="roughconductor", material="none", specular_reflectance=color, alpha=alpha)
        return dict(type="twosided", bsdf=metal)
    if m.kind == "plastic":
        plastic = dict(type="roughplastic", diffuse_reflectance=color, int_ior=m.ior, alpha=alpha)
        return dict(type="twosided", bsdf=plastic)
    return dict(type="twosided", bsdf=dict(type="diffuse", reflectance=color))


def _lamp(light):
    radiance = np.array(light.power) / (np.pi * light.radius**2)
    return dict(type="sphere", center=list(light.position), radius=light.radius,
                bsdf=dict(type="diffuse", reflectance=0.0), emitter=dict(type="area", radiance=_rgb(radiance)))


def _fog_bounds(scene, medium):
    """An invisible ball of fog around the scene."""
    return dict(type="sphere", radius=1.5 * scene.reach(), bsdf=dict(type="null"), interior=medium)


def _rgb(color):
    return dict(type="rgb", value=[float(c) for c in color])
