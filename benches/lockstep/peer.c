/* The least that keeps PX4 in lockstep: one blocking socket, constant sensor values, no dynamics, no log.
 *
 *     cc -O2 -o peer peer.c -lm && ./peer PORT
 *
 * Listens on loopback TCP PORT, sends HIL_SENSOR each 4 ms of simulated time and HIL_GPS each 100 ms, and waits for each
 * HIL_ACTUATOR_CONTROLS from the first one on; until then it keeps real time. Runs until the connection ends.
 */
#include <arpa/inet.h>
#include <math.h>
#include <netinet/tcp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <unistd.h>

enum { STEP_US = 4000, GPS_EVERY = 25, HIL_ACTUATOR_CONTROLS = 93, HIL_SENSOR = 107, HIL_GPS = 113 };

static uint16_t crc_add(uint16_t crc, uint8_t byte) {
    uint8_t x = byte ^ (uint8_t)crc;
    x ^= (uint8_t)(x << 4);
    return (uint16_t)((crc >> 8) ^ (x << 8) ^ (x << 3) ^ (x >> 4));
}

/* Appends a MAVLink 2 frame to `out`; returns its length. */
static size_t frame(uint8_t *out, uint8_t id, uint8_t crc_extra, const uint8_t *payload, uint8_t len) {
    static uint8_t sequence;
    const uint8_t head[10] = {0xFD, len, 0, 0, sequence++, 1, 51, id, 0, 0};
    memcpy(out, head, sizeof head);
    memcpy(out + 10, payload, len);
    uint16_t crc = 0xFFFF;
    for (size_t i = 1; i < 10u + len; i++) crc = crc_add(crc, out[i]);
    crc = crc_add(crc, crc_extra);
    out[10 + len] = (uint8_t)crc;
    out[11 + len] = (uint8_t)(crc >> 8);
    return 12u + len;
}

static size_t sensor(uint8_t *out, uint64_t time_us) {
    /* Two readings in turn: PX4 calls a barometer stale that never changes. */
    const float flip = (time_us / STEP_US) % 2 ? 0.005f : -0.005f;
    const float height_m = 488.0f;
    const float hpa = 1013.25f * powf(1.0f - 2.25577e-5f * height_m, 5.25588f) + flip;
    const float values[13] = {0.01f * flip, 0, -9.80665f, 0.01f * flip, 0, 0, 0.215f, 0.01f, 0.430f, hpa, 0, height_m, 20};
    const uint32_t fields = 0x1FFF & ~0x400u;
    uint8_t payload[64];
    memcpy(payload, &time_us, 8);
    memcpy(payload + 8, values, sizeof values);
    memcpy(payload + 60, &fields, 4);
    return frame(out, HIL_SENSOR, 108, payload, sizeof payload);
}

static size_t gps(uint8_t *out, uint64_t time_us) {
    const int32_t place[3] = {473977420, 85455940, 488000};
    const uint16_t accuracy_and_speed[3] = {90, 90, 0};
    uint8_t payload[36] = {0};
    memcpy(payload, &time_us, 8);
    memcpy(payload + 8, place, sizeof place);
    memcpy(payload + 20, accuracy_and_speed, sizeof accuracy_and_speed);
    payload[34] = 3;
    payload[35] = 12;
    return frame(out, HIL_GPS, 124, payload, sizeof payload);
}

/* Takes frames out of the stream; the number of HIL_ACTUATOR_CONTROLS among them. */
static int answers(uint8_t *buffer, size_t *held) {
    int count = 0;
    size_t at = 0;
    while (*held - at >= 12) {
        const uint8_t *f = buffer + at;
        if (f[0] != 0xFD) { at++; continue; }
        const size_t length = 12u + f[1] + (f[2] & 1 ? 13u : 0u);
        if (*held - at < length) break;
        count += f[7] == HIL_ACTUATOR_CONTROLS && !f[8] && !f[9];
        at += length;
    }
    memmove(buffer, buffer + at, *held -= at);
    return count;
}

int main(int argc, char **argv) {
    if (argc != 2) return fprintf(stderr, "usage: peer PORT\n"), 2;
    const int on = 1, server = socket(AF_INET, SOCK_STREAM, 0);
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons((uint16_t)atoi(argv[1]))};
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    setsockopt(server, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(server, (struct sockaddr *)&at, sizeof at) || listen(server, 1)) return perror("peer"), 2;
    const int px4 = accept(server, NULL, NULL);
    if (px4 < 0) return perror("peer"), 2;
    setsockopt(px4, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);

    uint8_t out[256], in[8192];
    size_t held = 0;
    int lockstep = 0;
    for (uint64_t step = 1;; step++) {
        size_t length = step % GPS_EVERY ? 0 : gps(out, step * STEP_US);
        length += sensor(out + length, step * STEP_US);
        if (write(px4, out, length) < 0) return 0;
        for (int got = 0; !got;) {
            if (!lockstep) {
                fd_set readable;
                FD_ZERO(&readable);
                FD_SET(px4, &readable);
                struct timeval pause = {0, STEP_US};
                if (select(px4 + 1, &readable, NULL, NULL, &pause) == 0) break;
            }
            const ssize_t n = read(px4, in + held, sizeof in - held);
            if (n <= 0) return 0;
            held += (size_t)n;
            got = answers(in, &held);
            lockstep |= got;
        }
    }
}
