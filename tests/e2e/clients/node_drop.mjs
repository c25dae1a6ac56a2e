// A drop flown by node-mavlink: hears the vehicle, arms, releases, flies a plan; what happened, as JSON.
//
//     node node_drop.mjs RECEIVE_PORT SEND_PORT SYSTEM TRAJECTORY.csv MISSION.json
//
// By its class for UDP, MavEsp8266, which answers the first address that it hears at a port of its own choice.

import { readFileSync } from 'node:fs'
import { createRequire } from 'node:module'

// The packages are not installed beside this file.
const { MavEsp8266, minimal, common } = createRequire(process.env.NODE_CLIENT + '/')('node-mavlink')

const [receivePort, sendPort, system, trajectory, missionFile] = process.argv.slice(2)
const AUTOPILOT = 1
const PARACHUTE = 161
const OFFBOARD = 6
const ATTITUDE_AND_THRUST = 0x07
const VELOCITY_ONLY = 0x0dc7
const SETPOINT_PERIOD_MS = 20
const PATIENCE_MS = 30_000
const REPEAT_MS = 1000

const mission = JSON.parse(readFileSync(missionFile, 'utf8'))
const rows = readFileSync(trajectory, 'utf8').trim().split('\n').filter(line => !line.startsWith('#')).map(line => line.split(','))
const columns = ['t_s', 'vn_m_s', 've_m_s', 'vd_m_s', 'an_m_s2', 'ae_m_s2', 'ad_m_s2'].map(name => rows[0].indexOf(name))
const nodes = rows.slice(1).map(row => columns.map(column => Number(row[column])))

/** Velocity [m/s] of the plan: cubic Hermite between the nodes, its ends held, then the target. */
function plannedVelocity(t) {
  if (t <= nodes[0][0]) return nodes[0].slice(1, 4)
  const next = nodes.findIndex(node => t < node[0])
  if (next < 0) return mission.target_v_ned_m_s
  const [a, b] = [nodes[next - 1], nodes[next]]
  const h = b[0] - a[0], s = (t - a[0]) / h, r = 1 - s
  return [1, 2, 3].map(
    i => a[i] * r * r * (1 + 2 * s) + a[i + 3] * h * s * r * r + b[i] * s * s * (3 - 2 * s) - b[i + 3] * h * s * s * r
  )
}

const REGISTRY = { ...minimal.REGISTRY, ...common.REGISTRY }
const port = new MavEsp8266()
const state = { nowMs: 0, sentMs: 0, freeMs: undefined, endMs: undefined, armed: false, offboard: false, unread: 0 }
const accepted = new Set()

function send(message, fields) {
  return port.send(Object.assign(message, fields), 245, 190)
}

function sendSetpoint() {
  const target = { timeBootMs: state.nowMs, targetSystem: Number(system), targetComponent: AUTOPILOT }
  if (state.freeMs === undefined) {
    const level = { q: [1, 0, 0, 0], thrust: 0, typeMask: ATTITUDE_AND_THRUST, thrustBody: [0, 0, 0] }
    return send(new common.SetAttitudeTarget(), { ...target, ...level })
  }
  const [vx, vy, vz] = plannedVelocity((state.nowMs - state.freeMs) * 1e-3)
  const zero = { x: 0, y: 0, z: 0, afx: 0, afy: 0, afz: 0, yaw: 0, yawRate: 0 }
  const frame = common.MavFrame.LOCAL_NED
  return send(new common.SetPositionTargetLocalNed(), {
    ...target, ...zero, vx, vy, vz, typeMask: VELOCITY_ONLY, coordinateFrame: frame
  })
}

const hear = {
  [minimal.Heartbeat.MSG_ID]: (m, component) => {
    if (component !== AUTOPILOT) return
    state.armed = (m.baseMode & minimal.MavModeFlag.SAFETY_ARMED) !== 0
    state.offboard = ((m.customMode >> 16) & 0xff) === OFFBOARD
  },
  [common.Attitude.MSG_ID]: m => {
    state.nowMs = m.timeBootMs
    if (state.nowMs - state.sentMs < SETPOINT_PERIOD_MS) return
    state.sentMs = state.nowMs
    sendSetpoint()
  },
  [common.CommandAck.MSG_ID]: (m, component) => {
    if (m.result === common.MavResult.ACCEPTED) accepted.add(`${component} ${m.command}`)
  },
  [common.NamedValueInt.MSG_ID]: m => {
    if (m.name === 't_release') state.freeMs = m.value + 1e3 * mission.parachute.delay_s
    if (m.name === 't_end') state.endMs = m.value
  }
}

async function until(what, condition, patienceMs = PATIENCE_MS) {
  const deadline = Date.now() + patienceMs
  while (!condition()) {
    if (Date.now() > deadline) throw new Error(`${what}: not within ${patienceMs} ms (at ${state.nowMs} ms)`)
    await new Promise(resolve => setTimeout(resolve, 5))
  }
}

/** Sends a command until it is accepted. */
async function command(component, number, ...params) {
  const deadline = Date.now() + PATIENCE_MS
  while (!accepted.has(`${component} ${number}`)) {
    if (Date.now() > deadline) throw new Error(`command ${number}: not accepted (at ${state.nowMs} ms)`)
    const fields = { targetSystem: Number(system), targetComponent: component, command: number, confirmation: 0 }
    for (let i = 0; i < 7; i++) fields[`_param${i + 1}`] = params[i] ?? 0
    await send(new common.CommandLong(), fields)
    await until('', () => accepted.has(`${component} ${number}`), REPEAT_MS).catch(() => undefined)
  }
}

port.on('data', packet => {
  const kind = REGISTRY[packet.header.msgid]
  if (kind === undefined) state.unread += 1
  else hear[packet.header.msgid]?.(packet.protocol.data(packet.payload, kind), packet.header.compid)
})
await port.start(Number(receivePort), Number(sendPort))
const station = { type: minimal.MavType.GCS, autopilot: minimal.MavAutopilot.INVALID, baseMode: 0, customMode: 0, systemStatus: 0 }
await send(new minimal.Heartbeat(), station)
const heartbeats = setInterval(() => send(new minimal.Heartbeat(), station), 500)
await until('setpoints', () => state.sentMs > 0)
await command(AUTOPILOT, common.MavCmd.DO_SET_MODE, minimal.MavModeFlag.CUSTOM_MODE_ENABLED, OFFBOARD)
await command(AUTOPILOT, common.MavCmd.COMPONENT_ARM_DISARM, 1)
await until('armed, in OFFBOARD', () => state.armed && state.offboard)
await command(PARACHUTE, common.MavCmd.DO_GRIPPER, 1, common.GripperActions.RELEASE)
await until('released', () => state.freeMs !== undefined)
await until('the end', () => state.endMs !== undefined, 10 * PATIENCE_MS)
clearInterval(heartbeats)
const released_s = state.freeMs * 1e-3 - mission.parachute.delay_s
console.log(JSON.stringify({ released_s, end_s: state.endMs * 1e-3, was_offboard: state.offboard }))
await port.close()
