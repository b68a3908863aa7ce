"""Renders a Scene or a Blender file with Blender's Cycles (the module `bpy`, Python 3.11).

Renders every feature of a Scene, but the camera does not see point lights. Albedo and normal are Cycles' denoising
passes: averages over the samples which, on mirrors and glass, come from the objects seen in them. Normals are in camera
space (x right, y up, z away from the viewer). Where a ray leaves the scene, the normal is 0 and the albedo is the
environment's color.
"""

import math
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from render.cycles_materials import Node, make_fog, make_image, make_material

sys.path.append(str(next(Path(bpy.utils.system_resource("PYTHON")).rglob("OpenImageIO")).parent))
import OpenImageIO  # noqa: E402  part of bpy, in a folder that only Blender itself searches

PASSES = (("Combined", "RGB"), ("Denoising Albedo", "RGB"), ("Denoising Normal", "XYZ"))
CHANNELS = [f"{name}.{axis}" for name, axes in PASSES for axis in axes]
GPU_KINDS = "OPTIX", "CUDA", "HIP", "ONEAPI", "METAL"  # Cycles' names, fastest first


class Cycles:
    """Renders the scene that is open in Blender; subclasses open it."""

    cameras = ()

    def render(self, camera, samples, seed, keep=None):
        """[9,H,W]: color, albedo, normal. `keep` is an optional path for the EXR file with all passes."""
        scene = bpy.context.scene
        scene.camera = self.cameras[camera]
        scene.cycles.samples, scene.cycles.seed = samples, seed
        with tempfile.TemporaryDirectory() as folder:
            part = keep.with_suffix(".part") if keep else Path(folder) / "render.part"
            scene.render.filepath = str(part.resolve())
            bpy.ops.render.render(write_still=True)
            image = read_passes(part)
            if keep:
                part.replace(keep)
        return image

    def use_gpu(self):
        """Switches rendering to this machine's GPUs."""
        preferences = bpy.context.preferences.addons["cycles"].preferences
        preferences.refresh_devices()
        for kind in GPU_KINDS:
            entries = preferences.get_devices_for_type(kind)
            if any(entry.type == kind for entry in entries):
                preferences.compute_device_type, bpy.context.scene.cycles.device = kind, "GPU"
                for entry in entries:
                    entry.use = entry.type == kind
                return
        raise SystemExit("Cycles finds no usable GPU: leave out --gpu")

    def set_up(self, threads):
        """Sets up plain Monte Carlo rendering without clamping or denoising, with all passes in one part of an EXR
        file."""
        scene, layer = bpy.context.scene, bpy.context.view_layer
        render, cycles, image = scene.render, scene.cycles, scene.render.image_settings
        render.engine, cycles.device = "CYCLES", "CPU"
        render.threads_mode, render.threads = "FIXED", threads
        render.use_persistent_data = True  # only seed and camera change between renders
        render.use_compositing = render.use_sequencer = render.use_multiview = render.use_border = False
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        cycles.use_animated_seed = cycles.use_sample_subset = False
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.time_limit = 0
        for other in scene.view_layers:
            other.use = other == layer
        layer.cycles.denoising_store_passes = True
        layer.samples = 0  # no override
        render.use_file_extension = False
        image.media_type, image.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
        image.color_depth, image.exr_codec, image.use_exr_interleave = "32", "ZIP", True


def read_image(path):
    """The header and the pixels [H,W,C] of an EXR file."""
    file = OpenImageIO.ImageInput.open(str(path))
    header, pixels = file.spec(), file.read_image("float")
    file.close()
    return header, pixels


def read_passes(path):
    """The nine channels of CHANNELS as [9,H,W]; in the file, the view layer's name is their prefix."""
    header, pixels = read_image(path)
    names = header.channelnames
    chosen = [next(i for i, name in enumerate(names) if name.endswith("." + channel)) for channel in CHANNELS]
    return np.ascontiguousarray(pixels[..., chosen].transpose(2, 0, 1))


class BlendRenderer(Cycles):
    """A Blender file, changed only by `set_up`; each of its cameras is a view."""

    def __init__(self, path, size=None, threads=1):
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
        self.cameras = sorted((o for o in bpy.context.scene.objects if o.type == "CAMERA"), key=lambda o: o.name)
        self.views = [o.name for o in self.cameras]
        if not self.views:
            raise SystemExit(f"{path}: no camera in this file: nothing to render")
        self.set_up(threads)
        if size:
            set_size(size)


class Renderer(Cycles):
    """A Scene. Meshes and materials are created once, however many instances share them."""

    name = "cycles"

    def __init__(self, scene, size, threads=1, pixel_filter="narrow"):
        if pixel_filter != "narrow":
            raise SystemExit(f"cycles: no pixel filter \"{pixel_filter}\", only \"narrow\"")
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
        self.made = {}
        self.root = add("root", None)
        for instance in scene.instances:
            self.add_instance(instance)
        for light in scene.lights:
            add_light(light)
        add_environment(scene.environment)
        if scene.fog:
            add_fog(scene)
        self.cameras = [add_camera(camera) for camera in scene.cameras]
        self.set_up(threads)
        self.set_scene(size)

    def set_scene(self, size):
        set_size(size)
        scene = bpy.context.scene
        scene.cycles.max_bounces, scene.cycles.volume_bounces, scene.cycles.blur_glossy = 8, 4, 0
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1
        scene.render.motion_blur_position = "START"
        scene.frame_set(0)

    def add_instance(self, instance):
        """Adds an object. Its matrix goes into the parent inverse, because an object's own transform cannot store
        shear."""
        mesh = self.once(instance.mesh, make_mesh)
        obj = add("instance", mesh)
        if not mesh.materials:
            mesh.materials.append(None)  # a slot; each object sets its own material
        obj.material_slots[0].link = "OBJECT"
        obj.material_slots[0].material = self.once(instance.material, make_material)
        obj.parent, obj.matrix_parent_inverse = self.root, Matrix(instance.matrix)
        if instance.motion is not None:
            for frame, share in ((0, 0), (1, 1)):
                obj.location = np.linalg.solve(instance.matrix[:3, :3], instance.motion) * share
                obj.keyframe_insert("location", frame=frame)

    def once(self, source, make):
        """The result of `make(source)`, cached per source."""
        if id(source) not in self.made:
            self.made[id(source)] = make(source)
        return self.made[id(source)]


def set_size(size):
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100


def add(name, data):
    obj = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(obj)
    return obj


def make_mesh(source):
    """A Blender mesh, with uvs per triangle corner."""
    mesh, corners = bpy.data.meshes.new("mesh"), np.ascontiguousarray(source.faces, np.int32).ravel()
    mesh.vertices.add(len(source.vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(source.vertices, np.float32).ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners)
    mesh.polygons.add(len(corners) // 3)
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    if source.uvs is not None:
        mesh.uv_layers.new().uv.foreach_set("vector", np.asarray(source.uvs, np.float32)[corners].ravel())
    mesh.update(calc_edges=True)
    if source.normals is None:
        mesh.shade_flat()
    else:
        mesh.normals_split_custom_set_from_vertices(source.normals)
    return mesh


def add_light(source):
    """Adds a point light; Blender takes the total power in watts."""
    light = bpy.data.lights.new("light", "POINT")
    strongest = max(source.power)
    light.color = [p / strongest for p in source.power]
    light.energy = 4 * math.pi * strongest
    light.shadow_soft_size, light.use_soft_falloff = source.radius, False
    add("light", light).location = source.position


def add_environment(rows):
    world = bpy.data.worlds.new("environment")
    bpy.context.scene.world = world
    world.cycles.sampling_method = "MANUAL"  # 1024 pixels wide; the automatic 4096 take seconds to prepare
    world.node_tree.nodes.clear()
    sky = (0.0, 0.0, 0.0)
    if rows is not None:
        sky = Node(world, "TexEnvironment")
        sky.node.image = make_image(rows)
    Node(world, "OutputWorld").set(Surface=Node(world, "Background").set(Color=sky))


def add_fog(scene):
    """Adds fog in a ball around the scene; if it filled the world, it would block the environment's light."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=1.5 * scene.reach())
    bpy.context.object.data.materials.append(make_fog(scene.fog))


def add_camera(source):
    camera = bpy.data.cameras.new("camera")
    camera.clip_start, camera.clip_end = 1e-3, 1e6
    camera.angle = math.radians(source.fov)
    camera.dof.use_dof = source.aperture > 0
    if source.aperture > 0:
        camera.dof.focus_distance = source.focus
        camera.dof.aperture_fstop = camera.lens / 1000 / (2 * source.aperture)  # the lens is in mm
    obj = add("camera", camera)
    obj.location = source.position
    obj.rotation_euler = (Vector(source.target) - Vector(source.position)).to_track_quat("-Z", "Y").to_euler()
    return obj
