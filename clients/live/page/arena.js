// The swarm's arena: positions, sensors and wheels of the robots, and the result of each trial.

import { arrow, begin, number, palette } from "/canvas.js";

/** Angle of one heading step, rad and °. */
const STEP = Math.PI / 32;
const DEGREES = 5.625;
/** Colours of the robots. */
const TINTS = ["a", "e", "c", "f"];
/** Maximum number of rows of the robot table. */
const ROBOTS = 8;
/** Minimum side of a field drawn in detail, screen px. */
const DETAILED = 220;
/** Maximum number of points of a path: one trial. */
const PLACES = 300;

const by = (id) => document.getElementById(id);
const bits = (row) => [0, 1, 2, 3, 4].map((bit) => (row >> bit) & 1);
/** Decodes the wheel speeds from two bits each: 0 stop, 1 medium, 2 high. */
const wheels = (output) => [(output & 1) + ((output >> 1) & 1), ((output >> 2) & 1) + ((output >> 3) & 1)];

export class Arena {
  constructor() {
    this.section = by("arena");
    this.canvas = by("arena-fields");
    this.paths = [];
  }

  /** Processes a frame of the server. */
  take(arena) {
    const before = this.arena;
    if (before && (before.writer_epoch !== arena.writer_epoch || before.trial !== arena.trial || before.frame > arena.frame)) this.paths = [];
    this.arena = arena;
    arena.fields.forEach((field, index) => this.walk(index, 0, field.object_px));
    arena.agents.forEach((agent, index) => this.walk(Math.floor(index / arena.team), 1 + (index % arena.team), agent.position_px));
  }

  walk(field, who, place) {
    const paths = (this.paths[field] ??= []);
    const path = (paths[who] ??= []);
    const last = path.at(-1);
    if (!last || last[0] !== place[0] || last[1] !== place[1]) path.push(place);
    if (path.length > PLACES) path.shift();
  }

  /** Returns the state as one sentence. */
  sentence() {
    const { host, trial, trial_count: trials, goal, frame } = this.arena;
    if (host === "ended") return `the swarm's field was closed after goal ${goal}, trial ${trial + 1} of ${trials}`;
    if (host === "waits") return "the swarm's field waits for `ebts agents`";
    return `trial ${trial + 1} of ${trials}: goal ${goal}, frame ${frame} of ${this.arena.trial_frames}, ${this.phase()}`;
  }

  phase() {
    const { frame, execution_frames: execution, trial_frames: whole } = this.arena;
    if (frame >= whole) return "over";
    return frame < execution ? "execution" : "evaluation";
  }

  /** Writes all numbers of one frame. */
  tell() {
    const { arena } = this;
    const [field] = arena.fields;
    const write = (id, text) => { by(id).textContent = text; };
    write("arena-trial", `${arena.trial + 1} of ${arena.trial_count}`);
    write("arena-goal", String(arena.goal));
    write("arena-frame", `${arena.frame} of ${arena.trial_frames}`);
    write("arena-phase", this.phase());
    write("arena-distance", `${number(field.distance_px, 1)} px`);
    write("arena-e1", number(field.e1_points, 1));
    write("arena-e2", field.reached_frame === null ? "not reached" : `${number(field.e2_points, 1)} (frame ${field.reached_frame})`);
    write("arena-points", arena.frame < arena.trial_frames ? "–" : `${number(field.points, 1)}, ${field.solved ? "carried" : "not carried"}`);
    const still = arena.driven || arena.frame >= arena.trial_frames ? "" : " · the robots stand still: no wheel commands";
    write("arena-preset", this.described() + still);
    by("arena-robots").replaceChildren(...arena.agents.slice(0, Math.min(ROBOTS, arena.team * arena.fields.length)).map((agent, index) => robot(agent, index)));
    by("arena-trials").replaceChildren(...arena.trials.map((trial) => ended(trial, arena)));
    this.section.dataset.told = arena.sequence;
  }

  /** Returns the description of the field's parameters. */
  described() {
    const { preset, half_side_px: half, yielding, friction_stall_forces: friction, field_count: fields } = this.arena;
    const percent = (part) => `${number(part * 100, 0)} %`;
    const parts = [`field ${preset}`, `${number(2 * half, 0)} px between walls`];
    if (friction === null) parts.push(`object speed: ${percent(yielding[0])} with one robot, ${percent(yielding[1])} with two`);
    else parts.push(`friction ${number(friction, 2)} of a robot's stall force; object speed by robots: ${yielding.map((part, k) => `${k + 1} ${percent(part)}`).join(", ")}`);
    const obstacles = this.arena.walls.length + this.arena.posts.length;
    if (obstacles > 0) parts.push(`${this.arena.walls.length} walls and ${this.arena.posts.length} posts inside`);
    if (fields > 1) parts.push(`${fields} fields, ${fields > this.arena.fields.length ? `the first ${this.arena.fields.length} drawn, ` : ""}numbers of the first`);
    return parts.join(" · ");
  }

  draw() {
    const { arena } = this;
    const { context, width, height } = begin(this.canvas);
    const colours = palette();
    const across = Math.ceil(Math.sqrt(arena.fields.length * (width / height)));
    const columns = Math.min(arena.fields.length, across);
    const rows = Math.ceil(arena.fields.length / columns);
    const side = Math.min(width / columns, height / rows);
    const [left, top] = [(width - side * columns) / 2, (height - side * rows) / 2];
    arena.fields.forEach((field, index) => {
      const view = new View(context, colours, arena, side - (columns > 1 ? 6 : 2));
      context.save();
      context.translate(left + (index % columns) * side + side / 2, top + Math.floor(index / columns) * side + side / 2);
      view.field(field, arena.agents.slice(index * arena.team, (index + 1) * arena.team), this.paths[index] ?? []);
      context.restore();
    });
  }
}

/** Draws one field, centred in the origin. */
class View {
  constructor(context, colours, arena, side) {
    Object.assign(this, { context, colours, arena, side });
    this.scale = side / (2 * arena.half_side_px);
    this.isDetailed = side >= DETAILED;
  }

  at([x, y]) {
    return [x * this.scale, -y * this.scale];
  }

  field(field, agents, paths) {
    const { context, colours, arena } = this;
    this.ground();
    context.save();
    context.beginPath();
    context.rect(-this.side / 2, -this.side / 2, this.side, this.side);
    context.clip();
    this.circle(field.goal_px, arena.goal_light_px, { stroke: colours.ok, width: 1, dash: [1, 5] });
    this.circle(field.goal_px, arena.goal_radius_px, { stroke: colours.ok, width: 2, dash: [6, 4] });
    this.obstacles();
    this.path(paths[0], colours.d, 2.5);
    agents.forEach((_, index) => this.path(paths[index + 1], colours[TINTS[index]], 1.25));
    this.circle(field.object_px, arena.object_radius_px, { fill: colours.d, stroke: colours.ink, width: field.solved ? 3 : 1 });
    agents.forEach((agent, index) => this.robot(agent, index));
    context.restore();
    context.strokeStyle = colours.ink;
    context.lineWidth = this.isDetailed ? 3 : 1.5;
    context.strokeRect(-this.side / 2, -this.side / 2, this.side, this.side);
    if (this.isDetailed) this.labels(field);
  }

  /** Draws walls and posts inside the field in the border colour. */
  obstacles() {
    const { context, colours, arena } = this;
    for (const { at_px: at, radius_px: radius } of arena.posts) this.circle(at, radius, { fill: colours.ink });
    context.strokeStyle = colours.ink;
    context.lineWidth = this.isDetailed ? 3 : 1.5;
    for (const { from_px: from, to_px: to } of arena.walls) {
      context.beginPath();
      context.moveTo(...this.at(from));
      context.lineTo(...this.at(to));
      context.stroke();
    }
  }

  /** Draws a grid line every 100 px. */
  ground() {
    const { context, colours, arena, side } = this;
    context.fillStyle = colours.ground;
    context.fillRect(-side / 2, -side / 2, side, side);
    if (!this.isDetailed) return;
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    for (let px = -Math.floor(arena.half_side_px / 100) * 100; px < arena.half_side_px; px += 100) {
      context.beginPath();
      context.moveTo(px * this.scale, -side / 2);
      context.lineTo(px * this.scale, side / 2);
      context.moveTo(-side / 2, px * this.scale);
      context.lineTo(side / 2, px * this.scale);
      context.stroke();
    }
  }

  circle(place, radius, { fill, stroke, width = 1, dash = [] }) {
    const { context } = this;
    context.beginPath();
    context.arc(...this.at(place), radius * this.scale, 0, 2 * Math.PI);
    if (fill) {
      context.fillStyle = fill;
      context.fill();
    }
    if (!stroke) return;
    context.setLineDash(dash);
    context.strokeStyle = stroke;
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
  }

  path(places, colour, width) {
    if (!places || places.length < 2) return;
    const { context } = this;
    context.globalAlpha = 0.55;
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    for (const place of places) context.lineTo(...this.at(place));
    context.stroke();
    context.globalAlpha = 1;
  }

  robot({ position_px: place, heading_steps: heading, row, output, touches }, index) {
    const { context, colours, arena } = this;
    const tint = colours[TINTS[index]];
    const radius = arena.agent_radius_px;
    const towards = (steps, length) => {
      const angle = (heading + steps) * STEP;
      return this.at([place[0] + length * Math.cos(angle), place[1] + length * Math.sin(angle)]);
    };
    const sees = bits(row);
    if (this.isDetailed) {
      [arena.ir_angle_steps, 0, -arena.ir_angle_steps].forEach((steps, sensor) => {
        const ray = (colour, width) => {
          context.strokeStyle = colour;
          context.lineWidth = width;
          context.beginPath();
          context.moveTo(...towards(steps, radius));
          context.lineTo(...towards(steps, arena.ir_range_px));
          context.stroke();
        };
        // Light outline, for contrast on any background.
        if (sees[sensor]) ray(colours.panel, 9);
        ray(sees[sensor] ? colours.bad : colours.soft, sees[sensor] ? 5 : 1);
      });
    }
    this.circle(place, radius, { fill: colours.panel, stroke: tint, width: (touches ? 5 : 2.5) * (this.isDetailed ? 1 : 0.5) });
    const [x, y] = this.at(place);
    if (!this.isDetailed) {
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(...towards(0, radius));
      context.strokeStyle = tint;
      context.stroke();
      return;
    }
    this.wheels(towards, wheels(output), radius, tint);
    [arena.photo_angle_steps, -arena.photo_angle_steps].forEach((steps, sensor) => {
      const [px, py] = towards(steps, radius * 0.8);
      context.beginPath();
      context.arc(px, py, 4.5, 0, 2 * Math.PI);
      context.fillStyle = sees[3 + sensor] ? colours.d : colours.panel;
      context.strokeStyle = sees[3 + sensor] ? colours.ink : colours.soft;
      context.lineWidth = 1;
      context.fill();
      context.stroke();
    });
    context.fillStyle = colours.ink;
    context.font = "700 13px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(String(index + 1), x, y);
    context.textAlign = "start";
    context.textBaseline = "alphabetic";
  }

  /** Draws both wheels; the arrow length is proportional to the speed. */
  wheels(towards, levels, radius, tint) {
    const { context, colours } = this;
    levels.forEach((level, wheel) => {
      const left = (wheel === 0 ? 0.52 : -0.52) * radius;
      const beside = (ahead) => towards(Math.atan2(left, ahead) / STEP, Math.hypot(ahead, left));
      context.strokeStyle = context.fillStyle = level ? tint : colours.soft;
      context.lineWidth = 3;
      if (level) arrow(context, beside(-radius * 0.62), beside((0.3 * level - 0.62) * radius), 7);
      else {
        context.beginPath();
        context.moveTo(...beside(-radius * 0.62));
        context.lineTo(...beside(-radius * 0.42));
        context.stroke();
      }
    });
  }

  labels(field) {
    const { context, colours, arena, side } = this;
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = colours.ok;
    const [x, y] = this.at(field.goal_px);
    const room = side / 2 - 8;
    context.textAlign = "center";
    // Above the goal, or below it near the upper wall.
    const above = y - arena.goal_radius_px * this.scale - 6;
    const place = [Math.max(-room + 20, Math.min(room - 20, x)), above > -room ? above : y + arena.goal_radius_px * this.scale + 14];
    context.strokeStyle = colours.ground;
    context.lineWidth = 4;
    context.strokeText(`goal ${arena.goal}`, ...place);
    context.fillText(`goal ${arena.goal}`, ...place);
    context.textAlign = "start";
    const [from, to] = [[-room, room - 2], [-room + 100 * this.scale, room - 2]];
    context.strokeStyle = context.fillStyle = colours.ink;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(from[0], from[1] - 5);
    context.lineTo(...from);
    context.lineTo(...to);
    context.lineTo(to[0], to[1] - 5);
    context.stroke();
    context.fillText("100 px", from[0] + 4, from[1] - 6);
  }
}

/** Returns a row of the robot table. */
function robot(agent, index) {
  const [x, y] = agent.position_px;
  const sensors = bits(agent.row).map((bit, sensor) => (bit ? `S${sensor + 1}` : "")).filter(Boolean).join(" ") || "nothing";
  const [left, right] = wheels(agent.output);
  const cells = [index + 1, number(x, 1), number(y, 1), number(agent.heading_steps * DEGREES, 1), sensors, agent.row, `${left} ${right}`, agent.touches ? "yes" : ""];
  return line(cells);
}

/** Returns a row of the trial table. */
function ended(trial, arena) {
  const { field_count: fields } = arena;
  const still = trial.missed_frames + trial.refused_frames;
  const outcome = fields > 1 ? `${trial.solved_fields} of ${fields} carried` : trial.solved_fields ? "carried" : "not carried";
  const row = line([trial.goal, number(trial.distance_px, 1), trial.reached_frame ?? "never", number(trial.points, 1), still ? `${outcome}; ${still} frame${still > 1 ? "s" : ""} without a reply` : outcome]);
  row.className = trial.solved_fields ? "good" : "";
  return row;
}

function line(cells) {
  const row = document.createElement("tr");
  for (const text of cells) row.insertCell().textContent = String(text);
  return row;
}
