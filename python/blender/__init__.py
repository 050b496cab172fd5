"""The add-on: `Light this view` in the sidebar of the 3D viewport."""

import threading
from typing import Any

import bpy

import klieg
import klieg.blender


class Settings(bpy.types.PropertyGroup):
    """What the user chooses; it is stored in the file."""

    profile: bpy.props.EnumProperty(
        name="Profile",
        items=[(name, name.capitalize(), meaning) for name, meaning in sorted(klieg.profiles().items())],
        default="natural",
    )
    roles: bpy.props.EnumProperty(
        name="Lights",
        items=[
            ("key", "Key", "One light"),
            ("key,fill", "Key and fill", "A second one softens the shadows of the first"),
            ("key,fill,rim", "Key, fill and rim", "A third one from behind draws the outline"),
        ],
        default="key,fill",
    )
    keep: bpy.props.BoolProperty(
        name="Keep other lights",
        description="Other lights stay and count; without it those that are not locked are hidden from renders",
    )
    generations: bpy.props.IntProperty(name="Generations", min=1, max=1000, default=100)
    seed: bpy.props.IntProperty(name="Seed", min=0, default=0)

    def options(self) -> dict[str, Any]:
        """Return them as klieg takes them."""
        return {
            "profile": self.profile,
            "lights": self.roles,
            "generations": self.generations,
            "seed": self.seed,
            "keep_lights": True,
        }


class LightView(bpy.types.Operator):
    """Search the lights that make the active camera's view easiest to see."""

    bl_idname = "klieg.light_view"
    bl_label = "Light This View"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012 - as Blender reads it

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Tell whether there is a view."""
        return context.scene.camera is not None

    def execute(self, context: Any) -> set[str]:
        """Search, and wait for it: for scripts."""
        settings = context.scene.klieg
        try:
            scene, view = klieg.blender.look(context, keep_lights=settings.keep)
            self.found = klieg.design(scene, view, **settings.options())
        except klieg.Error as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._finish(context)

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Search in the background, with a bar in the status bar."""
        settings = context.scene.klieg
        try:
            scene, view = klieg.blender.look(context, keep_lights=settings.keep)
        except klieg.Error as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.ended, self.progress = threading.Event(), 0.0
        self.found, self.fault = None, None
        options = settings.options()
        self.thread = threading.Thread(target=self._search, args=(scene, view, options), daemon=True)
        self.thread.start()
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self.timer = manager.event_timer_add(0.1, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Show how far the search is; Escape ends it with the best so far."""
        if event.type == "ESC":
            self.ended.set()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        manager, share = context.window_manager, self.progress
        manager.progress_update(100 * share)
        full = round(20 * share)
        context.workspace.status_text_set(
            f"klieg: {'█' * full}{'░' * (20 - full)} {share:.0%}, Esc takes the best so far"
        )
        if self.thread.is_alive():
            return {"RUNNING_MODAL"}
        manager.event_timer_remove(self.timer)
        manager.progress_end()
        context.workspace.status_text_set(None)
        if self.found is None:
            self.report({"ERROR"}, str(self.fault))
            return {"CANCELLED"}
        return self._finish(context)

    def _search(self, scene: Any, view: Any, options: dict[str, Any]) -> None:
        def told(progress: Any) -> bool:
            self.progress = progress.generation / (progress.generations or progress.generation)
            return not self.ended.is_set()

        try:
            self.found = klieg.design(scene, view, progress=told, **options)
        except Exception as error:
            self.fault = error

    def _finish(self, context: Any) -> set[str]:
        klieg.blender.place(context, self.found, keep_lights=context.scene.klieg.keep)
        self.report({"INFO"}, f"klieg: F {self.found.score:.4f}, a headlight {self.found.headlight_score:.4f}")
        return {"FINISHED"}


class Panel(bpy.types.Panel):
    """The sidebar's tab."""

    bl_idname = "VIEW3D_PT_klieg"
    bl_label = "klieg"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "klieg"

    def draw(self, context: Any) -> None:
        """Draw the choices and the button."""
        self.layout.use_property_split = True
        for name in ("profile", "roles", "keep", "generations", "seed"):
            self.layout.prop(context.scene.klieg, name)
        self.layout.operator(LightView.bl_idname, icon="LIGHT")


CLASSES = (Settings, LightView, Panel)


def register() -> None:
    """Make the add-on known to Blender."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.klieg = bpy.props.PointerProperty(type=Settings)


def unregister() -> None:
    """Take it away again."""
    del bpy.types.Scene.klieg
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
