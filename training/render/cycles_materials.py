"""A Scene's materials and images as Blender shader nodes, for cycles.py."""

import bpy
import numpy as np


class Node:
    """A shader node. `set` gives inputs a number, a color or the first output of another node."""

    def __init__(self, owner, kind):
        self.tree = owner.node_tree
        self.node = self.tree.nodes.new("ShaderNode" + kind)

    def set(self, **inputs):
        for name, value in inputs.items():
            socket = self.node.inputs[name.replace("_", " ")]
            if isinstance(value, Node):
                self.tree.links.new(value.node.outputs[0], socket)
            else:
                socket.default_value = (*value, 1) if np.ndim(value) else value
        return self


def make_material(source):
    """A Blender material with one shader, chosen by the kind."""
    material = bpy.data.materials.new(source.kind)
    material.node_tree.nodes.clear()
    shaders = dict(diffuse=_diffuse, plastic=_plastic, metal=_metal, glass=_glass, thin_leaf=_thin_leaf)
    shader = _emitter if source.emission is not None else shaders[source.kind]
    Node(material, "OutputMaterial").set(Surface=shader(material, source))
    return material


def make_fog(extinction):
    """A gray medium of albedo 0.9."""
    material = bpy.data.materials.new("fog")
    material.node_tree.nodes.clear()
    medium = Node(material, "VolumePrincipled")
    medium.set(Color=(0.9,) * 3, Absorption_Color=(0,) * 3, Density=extinction, Emission_Strength=0)
    Node(material, "OutputMaterial").set(Volume=medium)
    return material


def make_image(rows):
    """An in-memory float image of linear values; Blender's rows run from bottom to top."""
    height, width = rows.shape[:2]
    image = bpy.data.images.new("image", width, height, alpha=False, float_buffer=True, is_data=True)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = rows[::-1]
    image.pixels.foreach_set(pixels.ravel())
    return image


def _color(material, source):
    if source.texture is None:
        return [float(c) for c in source.color]
    texture = Node(material, "TexImage")
    texture.node.image = make_image(source.texture)
    return texture


def _surface(material, source, kind):
    """A shader node, with the normals of the bump map if there is one."""
    shader = Node(material, kind)
    if source.bump is None:
        return shader
    heights = Node(material, "TexImage")
    heights.node.image = make_image(np.repeat(source.bump[..., None], 3, 2))
    heights.node.interpolation = "Cubic"  # linear heights have facets
    return shader.set(Normal=Node(material, "Bump").set(Height=heights, Distance=1.0))


def _diffuse(material, source):
    return _surface(material, source, "BsdfDiffuse").set(Color=_color(material, source))


def _plastic(material, source):
    shader = _surface(material, source, "BsdfPrincipled")
    return shader.set(Base_Color=_color(material, source), Roughness=source.roughness, IOR=source.ior)


def _metal(material, source):
    shader = _surface(material, source, "BsdfPrincipled")
    return shader.set(Base_Color=_color(material, source), Roughness=source.roughness, Metallic=1)


def _glass(material, source):
    tint = np.sqrt(source.color).tolist()  # light passes two surfaces of an object, and each takes the root
    return _surface(material, source, "BsdfGlass").set(Color=tint, Roughness=source.roughness, IOR=source.ior)


def _thin_leaf(material, source):
    mix = Node(material, "MixShader").set(Fac=0.4)  # transmitted share
    for socket, kind in zip(mix.node.inputs[1:], ("BsdfDiffuse", "BsdfTranslucent")):
        side = _surface(material, source, kind).set(Color=_color(material, source))
        mix.tree.links.new(side.node.outputs[0], socket)
    return mix


def _emitter(material, source):
    return Node(material, "Emission").set(Color=source.emission)
