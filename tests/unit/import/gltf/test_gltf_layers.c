/* Layers of glTF's materials: coats, sheens, films, and light that is let through. */
#include "tests/unit/import/gltf/material_document.h"

TEST(clear_coats_are_read)
{
    struct scene s;
    const struct scene_material *m =
        read_one("\"extensions\": {\"KHR_materials_clearcoat\": {\"clearcoatFactor\": 0.5,"
                 "\"clearcoatTexture\": {\"index\": 1}, \"clearcoatRoughnessFactor\": 0.25,"
                 "\"clearcoatRoughnessTexture\": {\"index\": 0}, \"clearcoatNormalTexture\": "
                 "{\"index\": 0, \"scale\": 0.5}}}",
                 &s);
    assert_true(m->clearcoat == 0.5f && m->clearcoat_roughness == 0.25f);
    assert_int_equal(s.images[s.textures[m->clearcoat_texture.texture].image].flags, 0);
    assert_int_not_equal(m->clearcoat_roughness_texture.texture, SCENE_NONE);
    assert_int_not_equal(m->clearcoat_normal_texture.texture, SCENE_NONE);
    assert_true(m->clearcoat_normal_scale == 0.5f);
    assert_true(s.meshes[0].flags & MESH_HAS_TANGENTS);
    scene_unmap(&s);
    room_refuses("a.gltf",
                 document(WITH_UVS, "\"extensions\": {\"KHR_materials_clearcoat\": "
                                    "{\"clearcoatRoughnessFactor\": 1.5}}"),
                 ERR_RANGE,
                 "materials[0].extensions.KHR_materials_clearcoat.clearcoatRoughnessFactor");
}

TEST(sheens_are_read)
{
    struct scene s;
    const struct scene_material *m =
        read_one("\"extensions\": {\"KHR_materials_sheen\": {\"sheenColorFactor\": [0.5, 0.25, 1],"
                 "\"sheenColorTexture\": {\"index\": 1}, \"sheenRoughnessFactor\": 0.25,"
                 "\"sheenRoughnessTexture\": {\"index\": 0}}}",
                 &s);
    assert_true(m->sheen_color[1] == 0.25f && m->sheen_roughness == 0.25f);
    assert_int_equal(s.images[s.textures[m->sheen_color_texture.texture].image].flags,
                     IMAGE_IS_SRGB);
    assert_int_equal(s.images[s.textures[m->sheen_roughness_texture.texture].image].flags, 0);
    scene_unmap(&s);
}

TEST(diffuse_transmission_is_read)
{
    struct scene s;
    const struct scene_material *m =
        read_one("\"extensions\": {\"KHR_materials_diffuse_transmission\": "
                 "{\"diffuseTransmissionFactor\": 0.5,"
                 "\"diffuseTransmissionTexture\": {\"index\": 1}, "
                 "\"diffuseTransmissionColorFactor\": [1, 0.5, 0],"
                 "\"diffuseTransmissionColorTexture\": {\"index\": 0}}}",
                 &s);
    assert_true(m->diffuse_transmission == 0.5f && m->diffuse_transmission_color[1] == 0.5f);
    assert_int_equal(s.images[s.textures[m->diffuse_transmission_texture.texture].image].flags, 0);
    assert_int_equal(
        s.images[s.textures[m->diffuse_transmission_color_texture.texture].image].flags,
        IMAGE_IS_SRGB);
    scene_unmap(&s);
}

TEST(films_are_read)
{
    struct scene s;
    const struct scene_material *m =
        read_one("\"extensions\": {\"KHR_materials_iridescence\": {\"iridescenceFactor\": 0.5, "
                 "\"iridescenceIor\": 1.5, "
                 "\"iridescenceThicknessMinimum\": 200, \"iridescenceTexture\": {\"index\": 1}, "
                 "\"iridescenceThicknessTexture\": {\"index\": 0}}}",
                 &s);
    assert_true(m->iridescence == 0.5f && m->iridescence_ior == 1.5f);
    assert_true(m->iridescence_nm[0] == 200 && m->iridescence_nm[1] == 400);
    assert_int_not_equal(m->iridescence_texture.texture, SCENE_NONE);
    assert_int_not_equal(m->iridescence_thickness_texture.texture, SCENE_NONE);
    scene_unmap(&s);
}

TEST(dispersion_is_read)
{
    struct scene s;
    const struct scene_material *m =
        read_one("\"extensions\": {\"KHR_materials_dispersion\": {\"dispersion\": 0.5}}", &s);
    assert_true(m->dispersion == 0.5f);
    scene_unmap(&s);
}
