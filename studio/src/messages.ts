// Made of src/studio/ by its tests (KLIEG_WRITE_MESSAGES=1 writes it anew).

export type Camera = { 
/**
 * The point in the middle of the picture, world units.
 */
target: [number, number, number], 
/**
 * From where it looks, degrees: 0 on the +Z axis, positive to +X.
 */
azimuth: number, 
/**
 * The same upwards, degrees, -90 to 90.
 */
elevation: number, 
/**
 * From the target, scene radii.
 */
distance: number, 
/**
 * Vertical field of view, degrees; of an orthographic one, what the target's plane shows of it.
 */
yfov: number, 
/**
 * Whether all rays of the view are parallel.
 */
orthographic: boolean, 
/**
 * A camera of the file, which then stands in the place of all else that is said here.
 */
named: string | null, };
export type Light = { 
/**
 * What it is for. One of role `scene` stands in the file already, and no search changes it.
 */
role: 'key' | 'fill' | 'rim' | 'scene', 
/**
 * How it reaches the scene.
 */
kind: 'point' | 'directional' | 'spot', 
/**
 * From the scene's centre towards the light; any length.
 */
direction: [number, number, number], 
/**
 * From the scene's centre; a directional light has one too, and ignores it.
 */
distance: number, 
/**
 * Diffuse intensity.
 */
diffuse: number, 
/**
 * Specular intensity.
 */
specular: number, 
/**
 * Linear RGB; its luminance does not count, the server's has 1.
 */
color: [number, number, number], 
/**
 * Radius of the light itself.
 */
size: number, 
/**
 * Half angles of a spot's cone, inner and outer, degrees.
 */
cone: [number, number], 
/**
 * Unit axis of a spot's cone, away from the light; towards the scene's centre where null.
 */
aim: [number, number, number] | null, 
/**
 * Whether searches leave it as it is.
 */
locked: boolean, };
export type Targets = { 
/**
 * Mean brightness, sRGB-encoded, 0 to 1; that of the scene's own colours where null.
 */
mean: number | null, 
/**
 * Photographic stops by which that is moved, -4 to 4.
 */
stops: number, 
/**
 * Standard deviation of the brightness, sRGB-encoded, 0 to 0.5.
 */
spread: number, };
export type Mood = "soft" | "natural" | "dramatic";
export type Intent = { 
/**
 * Steps of brightness, −2..=2: each moves the mean brightness aimed at by 0.6 stops.
 */
brightness: number, 
/**
 * Steps of contrast, −2..=2: each moves the standard deviation of the brightness aimed at by 0.06 from 0.2, and
 * leaves the fill 0.6 of its share of the key.
 */
contrast: number, 
/**
 * The character.
 */
mood: Mood, 
/**
 * Whether lights may stand below the horizon of the scene's centre.
 */
below: boolean, };
export type Look = { 
/**
 * From where the scene is seen.
 */
camera: Camera, 
/**
 * 1 to 16 lights.
 */
lights: Array<Light>, 
/**
 * Weight of each term, by name; a term without one has 0.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * What light is wanted: searches stay in the boxes and above the horizon that it makes. Weights and targets are as
 * they are, whatever it says.
 */
intent: Intent, 
/**
 * Names of the objects for which it is wanted most.
 */
focus: Array<string>, 
/**
 * Names of the objects that are to stay dim.
 */
dim: Array<string>, };
export type Document = { 
/**
 * The scene's id; it holds as long as the server runs.
 */
scene: string | null, 
/**
 * Width and height of the picture, pixels.
 */
size: [number, number], 
/**
 * Whatever else the page keeps.
 */
page: unknown, 
/**
 * From where the scene is seen.
 */
camera: Camera, 
/**
 * 1 to 16 lights.
 */
lights: Array<Light>, 
/**
 * Weight of each term, by name; a term without one has 0.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * What light is wanted: searches stay in the boxes and above the horizon that it makes. Weights and targets are as
 * they are, whatever it says.
 */
intent: Intent, 
/**
 * Names of the objects for which it is wanted most.
 */
focus: Array<string>, 
/**
 * Names of the objects that are to stay dim.
 */
dim: Array<string>, };
export type Save = { 
/**
 * What is saved.
 */
document: Document, 
/**
 * Width of the picture; that of the document where null. So are the next two.
 */
width: number | null, 
/**
 * Its height.
 */
height: number | null, 
/**
 * Samples of a pixel, a square number up to 64; 16 where null.
 */
samples: number | null, };
export type Action = "start" | "pause" | "step" | "stop";
export type What = "highlight" | "shading" | "rim";
export type Open = { 
/**
 * Number of the request, which its answers carry.
 */
id: number, 
/**
 * A scene that was posted; that of the command line, if any, where null.
 */
scene: string | null, };
export type Draw = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * Width and height, pixels.
 */
size: [number, number], 
/**
 * Whether the final picture is wanted too.
 */
at_rest: boolean, 
/**
 * Width and height of that, pixels, of the same shape; those of `size` where null.
 */
rest: [number, number] | null, 
/**
 * From where the scene is seen.
 */
camera: Camera, 
/**
 * 1 to 16 lights.
 */
lights: Array<Light>, 
/**
 * Weight of each term, by name; a term without one has 0.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * What light is wanted: searches stay in the boxes and above the horizon that it makes. Weights and targets are as
 * they are, whatever it says.
 */
intent: Intent, 
/**
 * Names of the objects for which it is wanted most.
 */
focus: Array<string>, 
/**
 * Names of the objects that are to stay dim.
 */
dim: Array<string>, };
export type Map = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * Which light.
 */
light: number, 
/**
 * Cells side by side, up to 129.
 */
columns: number, 
/**
 * Cells above each other, up to 129.
 */
rows: number, 
/**
 * Width and height of the whole picture, whose shape the judged ones have.
 */
size: [number, number], 
/**
 * From where the scene is seen.
 */
camera: Camera, 
/**
 * 1 to 16 lights.
 */
lights: Array<Light>, 
/**
 * Weight of each term, by name; a term without one has 0.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * What light is wanted: searches stay in the boxes and above the horizon that it makes. Weights and targets are as
 * they are, whatever it says.
 */
intent: Intent, 
/**
 * Names of the objects for which it is wanted most.
 */
focus: Array<string>, 
/**
 * Names of the objects that are to stay dim.
 */
dim: Array<string>, };
export type Place = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * Which light.
 */
light: number, 
/**
 * What of it.
 */
what: What, 
/**
 * Pixel of the picture, from the left and from the top; fractions count.
 */
pixel: [number, number], 
/**
 * Width and height of that picture.
 */
size: [number, number], 
/**
 * From where it is seen.
 */
camera: Camera, 
/**
 * The lights as they stand.
 */
lights: Array<Light>, };
export type Pick = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * Pixel of the picture, from the left and from the top.
 */
pixel: [number, number], 
/**
 * Width and height of that picture.
 */
size: [number, number], 
/**
 * From where it is seen.
 */
camera: Camera, };
export type Search = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * What to do.
 */
action: Action, 
/**
 * Width and height of the picture that is judged.
 */
size: [number, number], 
/**
 * Name of an optimiser; that of the settings where null.
 */
optimizer: string | null, 
/**
 * Of every random choice; that of the settings where null.
 */
seed: number | null, 
/**
 * From where the scene is seen.
 */
camera: Camera, 
/**
 * 1 to 16 lights.
 */
lights: Array<Light>, 
/**
 * Weight of each term, by name; a term without one has 0.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * What light is wanted: searches stay in the boxes and above the horizon that it makes. Weights and targets are as
 * they are, whatever it says.
 */
intent: Intent, 
/**
 * Names of the objects for which it is wanted most.
 */
focus: Array<string>, 
/**
 * Names of the objects that are to stay dim.
 */
dim: Array<string>, };
export type Alternatives = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * How many, 2 to 24.
 */
count: number, 
/**
 * Width and height of the picture that is judged.
 */
size: [number, number], 
/**
 * From where the scene is seen.
 */
camera: Camera, 
/**
 * 1 to 16 lights.
 */
lights: Array<Light>, 
/**
 * Weight of each term, by name; a term without one has 0.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * What light is wanted: searches stay in the boxes and above the horizon that it makes. Weights and targets are as
 * they are, whatever it says.
 */
intent: Intent, 
/**
 * Names of the objects for which it is wanted most.
 */
focus: Array<string>, 
/**
 * Names of the objects that are to stay dim.
 */
dim: Array<string>, };
export type Preset = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * Name of a preset.
 */
name: string, };
export type Follow = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * The camera in whose frame the lights are told.
 */
from: Camera, 
/**
 * The camera in whose frame they are wanted.
 */
to: Camera, 
/**
 * The lights.
 */
lights: Array<Light>, };
export type Steer = { 
/**
 * See `Open`.
 */
id: number, 
/**
 * What was wanted before.
 */
from: Intent, 
/**
 * What is wanted.
 */
to: Intent, 
/**
 * The lights.
 */
lights: Array<Light>, };
export type Request = { "type": "open" } & Open | { "type": "draw" } & Draw | { "type": "map" } & Map | { "type": "place" } & Place | { "type": "pick" } & Pick | { "type": "search" } & Search | { "type": "alternatives" } & Alternatives | { "type": "preset" } & Preset | { "type": "follow" } & Follow | { "type": "steer" } & Steer;
export type Fineness = 0 | 1 | 2;
export type NamedCamera = { 
/**
 * Its name.
 */
name: string, 
/**
 * It, with the nearest that an orbit about the scene's centre has.
 */
camera: Camera, };
export type SceneInfo = { 
/**
 * What later requests call it.
 */
id: string, 
/**
 * The file's name.
 */
name: string, 
/**
 * Triangles.
 */
triangles: number, 
/**
 * The scene's centre, world units.
 */
center: [number, number, number], 
/**
 * The largest distance of a vertex from it, world units.
 */
radius: number, 
/**
 * The names of its objects, each once; of very many none.
 */
objects: Array<string>, 
/**
 * The file's cameras.
 */
cameras: Array<NamedCamera>, 
/**
 * Where a page begins to look from.
 */
camera: Camera, 
/**
 * Width and height of the picture that it begins with, pixels.
 */
size: [number, number], 
/**
 * The file's own lights, or those that klieg wrote; told in the frame of `camera`.
 */
lights: Array<Light>, 
/**
 * What a session file kept.
 */
document: Document | null, 
/**
 * What was left out in loading, for people.
 */
warnings: Array<string>, };
export type Defaults = { 
/**
 * Where a search would begin; none without a scene.
 */
lights: Array<Light>, 
/**
 * Weights of the terms.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * What light is wanted; weights and targets come of it.
 */
intent: Intent, 
/**
 * Names of the objects for which it is wanted most.
 */
focus: Array<string>, 
/**
 * Names of the objects that are to stay dim.
 */
dim: Array<string>, 
/**
 * Name of the optimiser.
 */
optimizer: string, 
/**
 * Seed of every random choice.
 */
seed: number, };
export type Titled = { 
/**
 * What requests call it.
 */
name: string, 
/**
 * What people call it.
 */
title: string, };
export type TermInfo = { 
/**
 * Its name in weights and judgements.
 */
name: string, 
/**
 * What people call it.
 */
title: string, 
/**
 * What it says of a picture: a sentence without its subject.
 */
meaning: string, 
/**
 * Its weight in the settings.
 */
weight: number, };
export type Device = { 
/**
 * The device's own name.
 */
name: string, 
/**
 * `cpu`, `discrete`, `integrated`, `virtual`, `software` or `other`.
 */
kind: string, };
export type Opened = { 
/**
 * Number of the request.
 */
id: number, 
/**
 * The scene; null where there is none yet.
 */
scene: SceneInfo | null, 
/**
 * Where to begin.
 */
defaults: Defaults, 
/**
 * Lights that do not depend on the scene, and `design`.
 */
presets: Array<Titled>, 
/**
 * The terms, in their order.
 */
terms: Array<TermInfo>, 
/**
 * Ways to search.
 */
optimizers: Array<Titled>, 
/**
 * What computes.
 */
device: Device, 
/**
 * klieg's version.
 */
version: string, };
export type Measured = { 
/**
 * Mean brightness, sRGB-encoded.
 */
mean: number, 
/**
 * What is aimed at.
 */
mean_target: number, 
/**
 * Standard deviation of the brightness.
 */
spread: number, 
/**
 * What is aimed at.
 */
spread_target: number, 
/**
 * Share of the object that is burnt out.
 */
burnt: number, 
/**
 * Share of the object that no light reaches.
 */
unlit: number, };
export type Judged = { 
/**
 * Number of the request.
 */
id: number, 
/**
 * `F`; lower is better.
 */
score: number, 
/**
 * Every term that can be measured, 0 to 1, whatever its weight; lower is better.
 */
terms: Record<string, number>, 
/**
 * What they were made from.
 */
measured: Measured, 
/**
 * Of the picture that was judged.
 */
quality: Fineness, };
export type Mapped = { 
/**
 * Number of the request.
 */
id: number, 
/**
 * Which light.
 */
light: number, 
/**
 * Cells side by side.
 */
columns: number, 
/**
 * Cells above each other.
 */
rows: number, 
/**
 * `F` of each cell, row by row from the top; null outside the disc. Lambert's azimuthal equal-area projection, the
 * viewer in its centre and the opposite direction on its rim.
 */
values: Array<number | null>, 
/**
 * The direction of the lowest of those in which a search may put the light.
 */
best: [number, number, number], 
/**
 * Unit vector upwards, light frame, where searches may put no light below the horizon.
 */
up: [number, number, number] | null, };
export type Progress = { 
/**
 * Number of the last request of the search.
 */
id: number, 
/**
 * Generations so far.
 */
generation: number, 
/**
 * Rigs that were judged.
 */
evaluations: number, 
/**
 * `F` of the best rig in the pictures that the search looks at.
 */
best: number, 
/**
 * The best rig.
 */
lights: Array<Light>, 
/**
 * Whether it looks at small pictures still.
 */
small: boolean, 
/**
 * Whether it goes on by itself.
 */
running: boolean, 
/**
 * Whether it has come to its end.
 */
finished: boolean, };
export type Answer = { "type": "opened" } & Opened | { "type": "judged" } & Judged | { "type": "mapped" } & Mapped | { "type": "placed", id: number, light: number, lit: Light, } | { "type": "missed", id: number, } | { "type": "picked", 
/**
 * Number of the request.
 */
id: number, 
/**
 * The object's name; null where there is none.
 */
name: string | null, 
/**
 * Its normal there, light frame.
 */
normal: [number, number, number] | null, 
/**
 * The place, light frame.
 */
position: [number, number, number] | null, } | { "type": "progress" } & Progress | { "type": "alternative", id: number, index: number, lights: Array<Light>, score: number, } | { "type": "alternatives_done", id: number, count: number, } | { "type": "rig", id: number, lights: Array<Light>, } | { "type": "steered", 
/**
 * Number of the request.
 */
id: number, 
/**
 * Weights of the terms.
 */
weights: Record<string, number>, 
/**
 * What they aim at.
 */
targets: Targets, 
/**
 * Radius of each light: that of the new mood, where it has another softness than the old one and the light is
 * searched.
 */
sizes: Array<number>, } | { "type": "fault", id: number | null, message: string, };
