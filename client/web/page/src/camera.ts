// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a hand does to a camera, as in the viewer (client/view/camera_control). Distances on the screen are parts of the
// picture's height. Pure functions.
import {clone} from '@bufbuild/protobuf';
import {CameraSchema, type Camera} from './generated/protocol/mote_pb';

type Vec = number[];
const add = (a: Vec, b: Vec): Vec => a.map((value, i) => value + b[i]);
const scale = (a: Vec, by: number): Vec => a.map((value) => value * by);
const sub = (a: Vec, b: Vec): Vec => add(a, scale(b, -1));
const dot = (a: Vec, b: Vec): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const length = (a: Vec): number => Math.sqrt(dot(a, a));
const unit = (a: Vec): Vec => scale(a, 1 / (length(a) || 1));
const cross = (a: Vec, b: Vec): Vec =>
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const clamp = (value: number, least: number, most: number) => Math.min(Math.max(value, least), most);

const stepFactor = 0.9;
const closest = 1e-6;
const farthest = 1e6;
const pole = 0.02;

function rotated(vector: Vec, angle: number, axis: Vec): Vec {
    const k = unit(axis);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return add(add(scale(vector, c), scale(cross(k, vector), s)), scale(k, dot(k, vector) * (1 - c)));
}

const upOf = (camera: Camera): Vec => camera.up.length === 3 ? camera.up : [0, 1, 0];
const tangent = (camera: Camera): number => Math.tan((camera.fovYDegrees ?? 35) * Math.PI / 360);

function heightAtTarget(camera: Camera): number {
    return camera.orthographicHeight ?? 2 * tangent(camera) * length(sub(camera.eye, camera.target));
}

function changed(camera: Camera, change: Partial<Camera>): Camera {
    return Object.assign(clone(CameraSchema, camera), change);
}

/// Turns the eye around the target: one height of the picture is half a turn. The poles are not crossed.
export function orbit(camera: Camera, dx: number, dy: number): Camera {
    const up = unit(upOf(camera));
    let arm = rotated(sub(camera.eye, camera.target), -dx * Math.PI, up);
    const right = unit(cross(up, arm));
    const polar = Math.acos(clamp(dot(unit(arm), up), -1, 1));
    arm = rotated(arm, clamp(polar - dy * Math.PI, pole, Math.PI - pole) - polar, right);
    return changed(camera, {eye: add(camera.target, arm)});
}

/// Moves eye and target with the hand, so that the target's plane sticks to it.
export function pan(camera: Camera, dx: number, dy: number): Camera {
    const sight = unit(sub(camera.target, camera.eye));
    const right = unit(cross(sight, upOf(camera)));
    const up = cross(right, sight);
    const offset = scale(add(scale(right, -dx), scale(up, dy)), heightAtTarget(camera));
    return changed(camera, {eye: add(camera.eye, offset), target: add(camera.target, offset)});
}

/// Moves the eye towards the target: each of `steps` goes a tenth of the way; without perspective the height narrows.
export function dolly(camera: Camera, steps: number): Camera {
    const by = Math.pow(stepFactor, steps);
    if (camera.orthographicHeight !== undefined)
        return changed(camera, {orthographicHeight: clamp(camera.orthographicHeight * by, closest, farthest)});
    const arm = sub(camera.eye, camera.target);
    const distance = length(arm);
    return changed(camera, {eye: add(camera.target, scale(arm, clamp(distance * by, closest, farthest) / distance))});
}

/// From the side of an axis; z is up, from above and below y.
export function lookFrom(camera: Camera, axis: number, positive: boolean): Camera {
    const away = [0, 0, 0];
    away[axis] = positive ? 1 : -1;
    const distance = length(sub(camera.eye, camera.target));
    return changed(camera, {eye: add(camera.target, scale(away, distance)), up: axis === 2 ? [0, 1, 0] : [0, 0, 1]});
}

/// The other projection, with the target's plane at the same size.
export function toggleProjection(camera: Camera): Camera {
    if (camera.orthographicHeight === undefined) return changed(camera, {orthographicHeight: heightAtTarget(camera)});
    const distance = 0.5 * camera.orthographicHeight / tangent(camera);
    const arm = unit(sub(camera.eye, camera.target));
    return changed(camera, {orthographicHeight: undefined, eye: add(camera.target, scale(arm, distance))});
}
