// SPDX-License-Identifier: MIT
// Results of an hour of driving, as a run would write them: 36,000 frames of laps through streets, with a map of a
// million landmarks, as many thumbnails as a run keeps, and a ground truth, for `turnscale view`.
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

const frames = 36000;
const landmarks = 1_000_000;
const features = 600; // of a thumbnail
const featureName = 'turnscale features\0';
const featureBytes = 4 + featureName.length + 3 * features;
const thumbnailBytes = 2_100_000; // of a run, at most (report/thumbnails.h)

/** Street corners along a growing spiral: heading at a distance. */
function drive() {
  const poses = [];
  let [x, z, heading, straight] = [0, 0, 0, 60];
  let left = straight;
  let turning = 0;
  const turns = [];
  for (let i = 0; i < frames; i++) {
    const speed = turning ? 5 : 11 + 2 * Math.sin(i / 90);
    poses.push({ x, z, heading, speed, turning: turning > 0 });
    const step = 0.1 * speed;
    x += step * Math.sin(heading);
    z += step * Math.cos(heading);
    if (turning) {
      heading += step / 8;
      turning -= step / 8;
      if (turning <= 0) {
        turns.at(-1).last = i;
        turning = 0;
        straight += 4;
        left = straight;
      }
    } else if ((left -= step) < 0) {
      turning = Math.PI / 2;
      turns.push({ first: i, last: i });
    }
  }
  return { poses, turns: turns.filter(({ first, last }) => last > first) };
}

/** `picture`: a JPEG file, which all thumbnails are. */
export function writeHour(folder, picture) {
  mkdirSync(join(folder, 'thumbnails'), { recursive: true });
  const { poses, turns } = drive();
  const write = (name, text) => writeFileSync(join(folder, name), text);
  const table = ['frame,time,state,x,y,z,qx,qy,qz,qw,scale_state,scale_sigma,inliers,tracked,keyframe,psi_deg,theta_deg,turning'];
  const speeds = ['time,speed_mps,sigma_mps'];
  const scale = ['frame,time,metres_per_unit,sigma'];
  poses.forEach(({ x, z, heading, speed, turning }, i) => {
    const time = (0.1 * i).toFixed(6);
    const state = i > 12000 && i < 12060 ? 'bridged' : 'tracked';
    table.push(`${i},${time},${state},${x.toFixed(4)},0,${z.toFixed(4)},0,${Math.sin(heading / 2).toFixed(9)},0,${Math.cos(heading / 2).toFixed(9)},${turning ? 'observed' : 'held'},0.02,200,300,${i % 4 ? 0 : 1},,,${turning ? 1 : 0}`);
    speeds.push(`${time},${speed.toFixed(3)},0.25`);
    if (i % 4 === 0) scale.push(`${i},${time},${(0.25 + 0.01 * Math.sin(i / 3000)).toFixed(5)},0.02`);
  });
  const turnTable = ['first_frame,last_frame,keyframes,angle_deg,speed_mps,metres_per_unit,sigma,smoothed_metres_per_unit,smoothed_sigma,deviation_sigmas,effective_lever_arm_m,used,reason,unadjusted'];
  turns.forEach(({ first, last }, i) => turnTable.push(`${first},${last},12,90,5,${(0.25 + 0.004 * Math.sin(i)).toFixed(4)},0.005,0.25,0.005,0.3,1.4,${i % 9 ? 1 : 0},${i % 9 ? '' : '"too fast"'},`));
  write('trajectory.csv', `${table.join('\n')}\n`);
  write('trajectory.tum', poses.map(({ x, z, heading }, i) => `${(0.1 * i).toFixed(6)} ${x.toFixed(4)} 0 ${z.toFixed(4)} 0 ${Math.sin(heading / 2).toFixed(9)} 0 ${Math.cos(heading / 2).toFixed(9)}\n`).join(''));
  // Grows by half a per cent, and leans to the left.
  write('truth.tum', poses.map(({ x, z, heading }, i) => `${(0.1 * i).toFixed(6)} ${(1.005 * x - 0.001 * z).toFixed(4)} 0 ${(1.005 * z).toFixed(4)} 0 ${Math.sin(heading / 2).toFixed(9)} 0 ${Math.cos(heading / 2).toFixed(9)}\n`).join(''));
  const count = Math.floor(thumbnailBytes / (picture.length + featureBytes));
  for (let i = 0; i < count; i++) {
    const frame = Math.floor((i * frames) / count);
    const why = poses[frame].turning ? 'turn' : frame > 12000 && frame < 12060 ? 'lost' : 'drive';
    // Features, which make each a file of its own.
    const comment = Buffer.alloc(featureBytes);
    comment.write(`\xff\xfe${featureName.padStart(featureName.length + 2)}`, 'latin1');
    comment.writeUInt16BE(comment.length - 2, 2);
    for (let k = 0; k < features; k++) comment.writeUIntBE((k * 27644437 + i * 104729) % 0x1000000, 4 + featureName.length + 3 * k, 3);
    writeFileSync(join(folder, 'thumbnails', `${String(frame).padStart(6, '0')}-${why}.jpg`), Buffer.concat([picture.subarray(0, 2), comment, picture.subarray(2)]));
  }
  write('speed.csv', `${speeds.join('\n')}\n`);
  write('scale.csv', `${scale.join('\n')}\n`);
  write('turns.csv', `${turnTable.join('\n')}\n`);
  write('camera_rotation.csv', 'frame,time,yaw_deg,pitch_deg,roll_deg,yaw_sigma_deg,pitch_sigma_deg,roll_sigma_deg,estimated\n0,0,0,0,0,,,,0\n300,30,1,2,0.5,0.2,0.2,1,1\n');
  const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${landmarks}\nend_header\n`;
  const body = Buffer.alloc(15 * landmarks, 200);
  for (let i = 0; i < landmarks; i++) {
    const { x, z, heading } = poses[Math.floor((i * frames) / landmarks)];
    const side = (i % 2 ? 1 : -1) * (5 + ((i * 7919) % 1000) / 200);
    body.writeFloatLE(x + side * Math.cos(heading), 15 * i);
    body.writeFloatLE(-((i * 104729) % 600) / 100, 15 * i + 4);
    body.writeFloatLE(z - side * Math.sin(heading), 15 * i + 8);
  }
  writeFileSync(join(folder, 'map.ply'), Buffer.concat([Buffer.from(header), body]));
  write('settings.yaml', 'vehicle:\n  lever_arm: 1.5\n');
  const distance = poses.reduce((sum, { speed }) => sum + 0.1 * speed, 0);
  write('summary.json', JSON.stringify({
    version: 'test', input: 'an hour <of> driving', pose_frame: 'camera', lever_arm_m: 1.5, camera_yaw_pitch_roll_deg: [0, 0, 0],
    intrinsics: { source: 'given' }, stopped: null, distance_m: distance, path_sigma: 0.012, warnings: ['the lever arm <is> doubtful'],
    frames: { total: frames, tracked: frames - 59 }, turns: { found: turns.length, used: turns.length - 5 },
    scale: { worst_relative_sigma: 0.02, worst_at_s: 4 },
    missing: { seconds: 6, of_s: 3600, longest: [{ reason: 'tracking lost', from_s: 1200, to_s: 1206 }] },
  }));
}
