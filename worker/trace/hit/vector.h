#pragma once
struct vector {
    float x, y, z;
};
