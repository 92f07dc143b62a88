// The payloads of the ATAS bus, for C11 (and C++ from 11 on).
//
// Made from the schema in shm-schemas/src: a test compares, and compiles it. How the payloads travel (services, quality of
// service, lock-step) stands in clients/protocol.md. All numbers are little-endian; there is no padding.
#ifndef ATAS_H
#define ATAS_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
#define _Static_assert static_assert
#define _Alignof alignof
#endif

// CRC-32 (IEEE 802.3, reflected, as in zip and Ethernet) over bytes: the seal of a payload.
static inline uint32_t atas_crc32(const void *bytes, size_t count) {
    const unsigned char *byte = (const unsigned char *)bytes;
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < count; i++) {
        crc ^= byte[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

// FNV-1a 64; begin with ATAS_FNV_OFFSET.
#define ATAS_FNV_OFFSET 0xcbf29ce484222325u
static inline uint64_t atas_fnv1a(uint64_t hash, const void *bytes, size_t count) {
    const unsigned char *byte = (const unsigned char *)bytes;
    for (size_t i = 0; i < count; i++) {
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    }
    return hash;
}

// The hash of a layout of `count` elements with their normals and tangents (unit vectors, tip frame): of the count, then
// of every direction in millionths, each as 8 bytes.
static inline uint64_t atas_layout_hash(uint64_t count, double normal[][3], double tangent1[][3], double tangent2[][3]) {
    double(*tables[3])[3] = {normal, tangent1, tangent2};
    uint64_t hash = atas_fnv1a(ATAS_FNV_OFFSET, &count, sizeof count);
    for (int table = 0; table < 3; table++) {
        for (uint64_t element = 0; element < count; element++) {
            for (int axis = 0; axis < 3; axis++) {
                int64_t micro = (int64_t)round(tables[table][element][axis] * 1e6);
                hash = atas_fnv1a(hash, &micro, sizeof micro);
            }
        }
    }
    return hash;
}
