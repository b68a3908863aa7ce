# SPDX-License-Identifier: MIT OR Apache-2.0
"""The interface without a window: the queue and its timer, Esc, and everything that the panel draws."""

import time
from types import SimpleNamespace

import bpy
import pytest
from conftest import MODULE
from test_render import leftovers


def poll_to_the_end(queue):
    """Polls until the queue is empty, like Blender's timer; returns the number of polls."""
    polls = 0
    while queue.busy:
        queue.poll()
        time.sleep(0.01)
        polls += 1
    return polls


def test_a_queued_render_is_denoised_on_a_thread(part, scene, queue):
    bpy.ops.render.render()
    bpy.ops.wgdenoise.render()
    expected = bpy.data.images["Scene denoised"].packed_file.data
    bpy.data.images.remove(bpy.data.images["Scene denoised"])
    queue.waiting.append(lambda: part("jobs").of_render(scene))
    assert poll_to_the_end(queue) > 1
    assert bpy.data.images["Scene denoised"].packed_file.data == expected


def test_what_cannot_be_denoised_leaves_the_queue(part, scene, queue):
    queue.waiting.append(lambda: part("jobs").of_folder(scene))
    poll_to_the_end(queue)
    assert queue.failed and "No folder is set" in queue.message


def test_an_error_while_making_a_job_does_not_end_the_timer(queue):
    queue.waiting.append(lambda: bpy.data.scenes["removed"])
    poll_to_the_end(queue)
    assert queue.failed and "removed" in queue.message


def test_an_error_while_showing_a_result_does_not_end_the_timer(part, scene, queue):
    bpy.ops.render.render()
    before, job = leftovers(), part("jobs").of_render(scene)
    job.deliver = lambda: bpy.data.images["removed"]
    queue.start(job)
    poll_to_the_end(queue)
    assert queue.failed and queue.message.startswith("The result could not be shown: ") and leftovers() == before


def test_a_render_that_runs_is_waited_for(part, scene, queue):
    rendering = [True]

    def make():
        if rendering:
            rendering.pop()
            raise part("render").Rendering("A render is running.")
        return part("jobs").of_render(scene)

    bpy.ops.render.render()
    queue.waiting.append(make)
    poll_to_the_end(queue)
    assert not rendering and "Scene denoised" in bpy.data.images and not queue.failed


class CancelOnMessage(list):
    """Cancels a job while it runs, when a message arrives."""

    def __init__(self, job):
        super().__init__()
        self.job = job

    def append(self, message):
        super().append(message)
        self.job.cancel()


@pytest.mark.parametrize("moment", ["before", "at a step"])
def test_a_canceled_job_changes_nothing(part, scene, queue, moment):
    bpy.ops.render.render()
    before = leftovers()
    job = part("jobs").of_render(scene)
    assert leftovers() != before
    if moment == "before":
        job.cancel()
    else:
        job.messages = CancelOnMessage(job)
    queue.start(job)
    poll_to_the_end(queue)
    assert queue.message == "Canceled" and not queue.failed
    assert "Scene denoised" not in bpy.data.images and leftovers() == before


def test_another_blender_file_cancels(part, scene, queue):
    bpy.ops.render.render()
    job = part("jobs").of_render(scene)
    queue.start(job)
    queue.waiting.append(lambda: pytest.fail("was not forgotten"))
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    poll_to_the_end(queue)
    assert job.canceled and "Scene denoised" not in bpy.data.images


def test_esc_cancels_and_the_operator_ends_with_the_job(part, scene, queue):
    bpy.ops.render.render()
    shown, removed, reports = [], [], []
    context = SimpleNamespace(
        workspace=SimpleNamespace(status_text_set=shown.append),
        window_manager=SimpleNamespace(event_timer_remove=removed.append),
    )
    job = part("jobs").of_render(scene)
    operator = part("operators")._Denoising()
    operator.job, operator.timer, operator.report = job, "timer", lambda kind, text: reports.append((kind, text))
    queue.start(job)
    tick, esc = SimpleNamespace(type="TIMER", value="NOTHING"), SimpleNamespace(type="ESC", value="PRESS")
    assert operator.modal(context, tick) == {"PASS_THROUGH"} and shown[-1].startswith("Denoising: ")
    assert operator.modal(context, esc) == {"RUNNING_MODAL"} and job.canceled
    poll_to_the_end(queue)
    assert operator.modal(context, tick) == {"CANCELLED"}
    assert shown[-1] is None and removed == ["timer"] and reports == [({"INFO"}, "Canceled")]


def test_disabling_ends_the_job_and_leaves_nothing_behind(part, scene, queue):
    bpy.ops.render.render()
    before = leftovers()
    job = part("jobs").of_render(scene)
    poll, handlers_by_name = part("automatic").poll, [*part("automatic")._HANDLERS]
    queue.start(job)
    bpy.ops.preferences.addon_disable(module=MODULE)
    try:
        assert not job.is_alive() and leftovers() == before
        assert not hasattr(bpy.types.Scene, "wgdenoise") and not bpy.app.timers.is_registered(poll)
        lists = [getattr(bpy.app.handlers, name) for name in handlers_by_name]
        assert not any(handler.__module__.startswith(MODULE) for handlers in lists for handler in handlers)
    finally:
        bpy.ops.preferences.addon_enable(module=MODULE)


class Layout:
    """Records what is drawn, and fails where Blender's own layout would."""

    icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys()

    def __init__(self):
        self.drawn, self.operators = [], []

    def row(self, **_):
        return self

    column = row

    def label(self, text="", icon="NONE"):
        assert icon in self.icons
        self.drawn.append(text)

    def prop(self, data, name, placeholder=""):
        assert name in data.bl_rna.properties
        self.drawn.append(name)

    def operator(self, name, text="", icon="NONE"):
        assert icon in self.icons
        area, operator = name.split(".")
        assert hasattr(bpy.types, f"{area.upper()}_OT_{operator}")
        self.drawn.append(name)
        self.operators.append(name)

    def progress(self, factor=0.0, text=""):
        assert 0 <= factor <= 1
        self.drawn.append(text)

    def separator(self):
        pass


def drawn(part):
    layout = Layout()
    part("panel").WGDENOISE_PT_render.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout.drawn


def test_the_panel_has_every_setting_and_button(part, scene):
    settings = [name for name in scene.wgdenoise.bl_rna.properties.keys() if name not in ("rna_type", "name")]
    shown = drawn(part)
    assert {*settings, "device", "wgdenoise.render", "wgdenoise.folder"} == {*shown} and len(shown) == len({*shown})


def test_the_panel_offers_missing_passes(part, scene):
    bpy.context.view_layer.cycles.denoising_store_passes = False
    assert "wgdenoise.enable_passes" in drawn(part)
    scene.render.engine = "BLENDER_WORKBENCH"
    assert "wgdenoise.enable_passes" not in drawn(part)
    assert any("color alone" in text for text in drawn(part))


def test_the_panel_shows_progress_and_cancel_while_a_job_runs(part, scene, queue):
    bpy.ops.render.render()
    queue.start(part("jobs").of_render(scene))
    shown = drawn(part)
    assert "wgdenoise.cancel" in shown and "wgdenoise.render" not in shown
    assert any(text.startswith("Denoising: ") for text in shown)
    assert not bpy.ops.wgdenoise.render.poll()
    bpy.ops.wgdenoise.cancel()
    assert any(text.startswith("Stopping") for text in drawn(part))
    poll_to_the_end(queue)
    assert "Canceled" in drawn(part) and "wgdenoise.render" in drawn(part)


def test_the_panel_shows_errors_whole(part, scene, queue):
    queue.fail("A long sentence that needs more than one line of a narrow panel to be shown in full.")
    assert queue.message in " ".join(drawn(part))


def test_the_image_menu_has_the_entry(part, scene):
    layout = Layout()
    part("panel").draw_menu(SimpleNamespace(layout=layout), bpy.context)
    assert layout.operators == ["wgdenoise.render"]


def test_devices_are_offered_by_name(part, scene):
    import wgdenoise

    names = part("settings")._device_names(None, bpy.context, "")
    assert names == [device.name for device in wgdenoise.devices()] and names
