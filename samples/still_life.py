"""The still life for render_samples.py: a procedural Blender scene without texture or model files.

Lengths are in metres, z points up, colors are linear RGB.
"""
import math

import bpy
from mathutils import Vector


# ---- materials ----

def material(name, color=(0.8, 0.8, 0.8), roughness=0.5, **inputs):
    """A Principled material. `color` is linear RGB; `inputs` sets other sockets, with _ for a space."""
    mat = bpy.data.materials.new(name)
    bsdf = mat.node_tree.nodes["Principled BSDF"]
    values = {"Base Color": (*color, 1), "Roughness": roughness}
    values |= {key.replace("_", " "): value for key, value in inputs.items()}
    for key, value in values.items():
        bsdf.inputs[key].default_value = value
    return mat


def textured(mat, kind, stops, scale, factor="Fac", stretch=(1, 1, 1), **settings):
    """Colors `mat` with a procedural texture node of type `kind` and a ramp of (position, linear RGB) stops."""
    nodes, links = mat.node_tree.nodes, mat.node_tree.links
    place, mapping = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeMapping")
    texture, ramp = nodes.new(kind), nodes.new("ShaderNodeValToRGB")
    mapping.inputs["Scale"].default_value = stretch
    texture.inputs["Scale"].default_value = scale
    for key, value in settings.items():
        texture.inputs[key.replace("_", " ")].default_value = value
    while len(ramp.color_ramp.elements) < len(stops):
        ramp.color_ramp.elements.new(0.5)
    for element, (position, color) in zip(ramp.color_ramp.elements, stops):
        element.position, element.color = position, (*color, 1)
    links.new(place.outputs["Position"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs[factor], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return mat


# ---- geometry ----

def dress(mat, smooth=False, bevel=0.0):
    """Gives the newest object its material, smooth shading and rounded edges."""
    obj = bpy.context.object
    obj.data.materials.append(mat)
    obj.name, obj.pass_index = mat.name, len(bpy.data.objects)
    if smooth:
        bpy.ops.object.shade_smooth()
    if bevel:
        modifier = obj.modifiers.new("bevel", "BEVEL")
        modifier.width, modifier.segments = bevel, 3
    return obj


def box(mat, center, size, turn=0.0, bevel=0.0):
    bpy.ops.mesh.primitive_cube_add(size=1, location=center, rotation=(0, 0, turn))
    bpy.context.object.scale = size
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    return dress(mat, bevel=bevel)


def ball(mat, center, radius):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=radius, location=center)
    return dress(mat, smooth=True)


def mesh(mat, points, faces, center, smooth=False):
    data = bpy.data.meshes.new(mat.name)
    data.from_pydata(points, [], faces)
    obj = bpy.data.objects.new(mat.name, data)
    bpy.context.collection.objects.link(obj)
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    obj.location = center
    return dress(mat, smooth)


def lathe(mat, profile, center, steps=96):
    """Revolves an open profile of (radius, height) points around the z axis."""
    angles = [2 * math.pi * i / steps for i in range(steps)]
    points = [(r * math.cos(a), r * math.sin(a), z) for r, z in profile for a in angles]
    faces = [(j * steps + i, j * steps + (i + 1) % steps, (j + 1) * steps + (i + 1) % steps, (j + 1) * steps + i)
             for j in range(len(profile) - 1) for i in range(steps)]
    return mesh(mat, points, faces, center, smooth=True)


def tuft(mat, center, leaves=46):
    """Thin bent leaves, each a strip of four quads ending in a point."""
    points, faces = [], []
    for i in range(leaves):
        angle, lean, height = 2.399 * i, 0.08 + 0.5 * (i * 0.618 % 1), 0.55 + 0.45 * (i * 0.382 % 1)
        along, side = Vector((math.cos(angle), math.sin(angle), 0)), Vector((-math.sin(angle), math.cos(angle), 0))
        for t in (0, 0.25, 0.5, 0.75, 1):
            middle = along * (0.06 + lean * t * t) + Vector((0, 0, height * (t - 0.4 * lean * t * t)))
            points += [middle + side * 0.016 * (1 - t), middle - side * 0.016 * (1 - t)]
        faces += [(10 * i + 2 * j, 10 * i + 2 * j + 1, 10 * i + 2 * j + 3, 10 * i + 2 * j + 2) for j in range(4)]
    return mesh(mat, points, faces, center)


# ---- scene ----

def build_room():
    """Floor, walls, a framed picture, and a window in the back wall with sky behind it."""
    wood = textured(material("floor wood", roughness=0.3), "ShaderNodeTexNoise", [
        (0.3, (0.06, 0.024, 0.010)), (0.5, (0.22, 0.10, 0.04)), (0.7, (0.38, 0.20, 0.09))],
        1.4, stretch=(6, 0.6, 1), Detail=5, Distortion=0.5)
    paper = textured(material("wallpaper", roughness=0.8), "ShaderNodeTexVoronoi", [
        (0.16, (0.62, 0.50, 0.30)), (0.20, (0.07, 0.17, 0.20)), (0.5, (0.12, 0.27, 0.30))],
        4.0, factor="Distance", stretch=(1, 0.01, 1), Randomness=0.0)
    plaster, white = material("plaster", (0.72, 0.68, 0.62), 0.9), material("white paint", (0.78, 0.77, 0.74), 0.3)
    for i in range(-11, 12):  # rounded edges leave visible grooves between the boards
        box(wood, (0.33 * i, -1, -0.05), (0.325, 9, 0.1), bevel=0.008)
    for x, z, width, height in ((-3.0, 1.8, 1.4, 3.8), (1.25, 1.8, 4.9, 3.8), (-1.75, 0.4, 1.1, 1.0), (-1.75, 3.2, 1.1, 1)):
        box(paper, (x, 3.3, z), (width, 0.12, height))
    for x, z, width, height in ((-2.3, 1.8, 0.1, 1.9), (-1.2, 1.8, 0.1, 1.9), (-1.75, 0.88, 1.2, 0.1),
                                (-1.75, 2.72, 1.2, 0.1), (-1.75, 1.8, 0.05, 1.8), (-1.75, 1.95, 1.1, 0.05)):
        box(white, (x, 3.26, z), (width, 0.16 if width < height else 0.14, height), bevel=0.012)  # no coplanar faces
    box(white, (0, 3.2, 0.11), (7.4, 0.1, 0.22), bevel=0.02)
    sky = material("sky", (0, 0, 0), Emission_Color=(0.55, 0.77, 1.0, 1), Emission_Strength=8.0)
    mesh(sky, [(-4, 4.4, 0), (0.5, 4.4, 0), (0.5, 4.4, 4), (-4, 4.4, 4)], [(0, 1, 2, 3)], (0, 0, 0))
    for center, size in (((0, -1, 3.75), (8, 9, 0.1)), ((-3.65, -1, 1.8), (0.1, 9, 3.8)), ((3.65, -1, 1.8), (0.1, 9, 3.8))):
        box(plaster, center, size)
    box(material("frame", (0.02, 0.015, 0.012), 0.25), (1.15, 3.2, 2.05), (1.5, 0.1, 1.1), bevel=0.03)
    box(textured(material("picture", roughness=0.6), "ShaderNodeTexNoise", [
        (0.38, (0.02, 0.05, 0.20)), (0.45, (0.70, 0.14, 0.04)), (0.52, (0.85, 0.55, 0.10)), (0.60, (0.75, 0.72, 0.60))],
        1.8, stretch=(1, 1, 3), Detail=5, Distortion=1.5), (1.15, 3.14, 2.05), (1.3, 0.02, 0.9))


def build_table():
    marble = textured(material("marble", roughness=0.12), "ShaderNodeTexNoise", [
        (0.44, (0.72, 0.70, 0.66)), (0.5, (0.26, 0.25, 0.25)), (0.53, (0.70, 0.68, 0.64))], 1.3, Detail=6, Distortion=1.2)
    steel = material("steel", (0.55, 0.55, 0.56), 0.3, Metallic=1)
    box(marble, (0, 0.55, 0.65), (3.7, 1.7, 0.07), bevel=0.02)
    for x, y in ((-1.7, -0.15), (1.7, -0.15), (-1.7, 1.25), (1.7, 1.25)):
        box(steel, (x, y, 0.31), (0.06, 0.06, 0.62))
    box(textured(material("rug", roughness=1), "ShaderNodeTexChecker", [
        (0, (0.42, 0.06, 0.04)), (1, (0.65, 0.52, 0.34))], 5, stretch=(1, 1, 0.01)), (0, 0.15, 0.012), (3.3, 2.3, 0.02))


def build_objects(top=0.686):
    """The still life on the table; `top` is the height of the table's surface."""
    glass = material("glass", (0.98, 1, 0.99), 0, Transmission_Weight=1, IOR=1.45)
    ball(glass, (-0.52, 0.05, top + 0.27), 0.27)
    lathe(textured(material("pot", roughness=0.25), "ShaderNodeTexWave", [
        (0.3, (0.75, 0.70, 0.60)), (0.5, (0.06, 0.12, 0.42))], 4, stretch=(1, 1, 1), Distortion=3, Detail=2),
        [(0, 0), (0.2, 0), (0.3, 0.12), (0.33, 0.28), (0.28, 0.44), (0.2, 0.5), (0.24, 0.55), (0.2, 0.53), (0.17, 0.48), (0, 0.44)],
        (-1.15, 0.65, top))
    tuft(material("leaf", (0.10, 0.30, 0.04), 0.4), (-1.15, 0.65, top + 0.44))
    bpy.ops.mesh.primitive_monkey_add(size=0.75, location=(0.2, 0.65, top + 0.36), rotation=(-0.35, 0, 0.15))
    dress(material("copper", (0.93, 0.50, 0.30), 0.28, Metallic=1), smooth=True).modifiers.new("smooth", "SUBSURF").levels = 2
    ball(material("chrome", (0.9, 0.9, 0.9), 0.02, Metallic=1), (-0.1, -0.08, top + 0.13), 0.13)
    ball(material("red glaze", (0.60, 0.02, 0.02), 0.08, Coat_Weight=1), (0.42, 0.02, top + 0.17), 0.17)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.2, location=(-1.15, -0.02, top + 0.19))
    dress(material("gold wire", (1.0, 0.72, 0.25), 0.2, Metallic=1)).modifiers.new("wire", "WIREFRAME").thickness = 0.014
    box(textured(material("mosaic", roughness=0.7), "ShaderNodeTexVoronoi", [
        (0, (0.75, 0.2, 0.05)), (0.35, (0.05, 0.35, 0.30)), (0.65, (0.8, 0.65, 0.2)), (1, (0.15, 0.08, 0.35))],
        11, factor="Color"), (0.95, 0.08, top + 0.16), (0.32, 0.32, 0.32), turn=0.5, bevel=0.015)
    for i, color in enumerate(((0.05, 0.10, 0.30), (0.55, 0.35, 0.10), (0.10, 0.25, 0.12), (0.45, 0.06, 0.08))):
        box(material(f"book {i}", color, 0.5), (1.3, 0.85, top + 0.05 + 0.1 * i), (0.75, 0.5, 0.092),
            turn=0.2 - 0.17 * (i % 3), bevel=0.012)
    lathe(material("brass", (0.8, 0.6, 0.25), 0.25, Metallic=1),
          [(0.14, 0), (0.14, 0.02), (0.02, 0.04), (0.02, 0.2), (0.07, 0.22)], (1.3, 0.85, top + 0.4))


def build_lamp(center, color):
    """A glowing globe. A point light does the lighting, with less noise than the visible mesh would make."""
    bpy.ops.object.light_add(type="POINT", location=center, radius=0.16)
    light = bpy.context.object
    light.data.energy, light.data.color = 12, color
    light.visible_glossy = light.visible_transmission = False
    globe = ball(material("globe", (0, 0, 0), Emission_Color=(*color, 1), Emission_Strength=11), center, 0.165)
    globe.visible_diffuse = globe.visible_shadow = False
    globe.active_material.cycles.emission_sampling = "NONE"


def build_lights_and_camera():
    bpy.ops.object.light_add(type="AREA", location=(-2.4, -2.6, 3.3), rotation=(0.75, 0, -0.75))
    bpy.context.object.data.size, bpy.context.object.data.energy = 1.6, 110
    build_lamp(Vector((1.3, 0.85, 1.47)), (1.0, 0.60, 0.26))
    bpy.ops.object.camera_add(location=(0.35, -4.4, 1.75))
    camera = bpy.context.object
    camera.rotation_euler = (Vector((-0.05, 0.6, 0.98)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens = 42
    bpy.context.scene.camera = camera


def build():
    """Replaces the scene open in Blender with the still life."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for step in (build_room, build_table, build_objects, build_lights_and_camera):
        step()
