/* glTF's material extensions and our extras: what becomes of them, what they are refused for. */
#include "tests/unit/import/gltf/material_document.h"

TEST(absent_extensions_mean_defaults)
{
    struct scene s;
    const struct scene_material *m = read_one("", &s);
    assert_true(m->model == MODEL_GLTF && m->metallic == 1 && m->roughness == 1);
    assert_true(m->specular == 1 && m->specular_color[2] == 1 && m->ior == 1.5f);
    assert_true(m->transmission == 0 && m->thickness == 0 && m->anisotropy == 0);
    assert_true(m->attenuation[0] == 1 && m->attenuation_distance == 0);
    assert_int_equal(m->transmission_texture.texture, SCENE_NONE);
    assert_int_equal(m->specular_texture.texture, SCENE_NONE);
    assert_int_equal(m->specular_color_texture.texture, SCENE_NONE);
    assert_int_equal(m->anisotropy_texture.texture, SCENE_NONE);
    scene_unmap(&s);
}

TEST(coats_are_read)
{
    struct scene s;
    const struct scene_material *m =
        read_one("\"extensions\": {\"KHR_materials_specular\": {\"specularFactor\": 0.25,"
                 "\"specularTexture\": {\"index\": 0}, \"specularColorFactor\": [0.5, 1, 3],"
                 "\"specularColorTexture\": {\"index\": 1, \"texCoord\": 1}},"
                 "\"KHR_materials_ior\": {\"ior\": 0}}",
                 &s);
    assert_true(m->specular == 0.25f && m->ior == 0);
    assert_true(m->specular_color[0] == 0.5f && m->specular_color[2] == 3);
    const struct scene_texture *textures = s.textures;
    assert_int_equal(s.images[textures[m->specular_texture.texture].image].flags, 0);
    assert_int_equal(s.images[textures[m->specular_color_texture.texture].image].flags,
                     IMAGE_IS_SRGB);
    assert_int_equal(m->specular_color_texture.uv_set, 1);
    assert_true(room_warned("lacks the texture coordinates"));
    scene_unmap(&s);
}

TEST(solids_are_read)
{
    struct scene s;
    const struct scene_material *m = read_one(
        "\"extensions\": {\"KHR_materials_transmission\": {\"transmissionFactor\": 0.75,"
        "\"transmissionTexture\": {\"index\": 0}}, \"KHR_materials_volume\": {\"thicknessFactor\": "
        "2, \"thicknessTexture\": {\"index\": 1}, \"attenuationColor\": [0, 0.5, 1],"
        "\"attenuationDistance\": 3}}",
        &s);
    assert_true(m->transmission == 0.75f && m->thickness == 2 && m->attenuation_distance == 3);
    assert_true(m->attenuation[0] == FLT_MIN && m->attenuation[1] == 0.5f);
    assert_int_equal(m->transmission_texture.texture, 0);
    assert_int_equal(s.count[SCENE_TEXTURES], 1); /* that of the thickness is not kept */
    assert_true(room_warned("thicknessTexture is ignored"));
    scene_unmap(&s);
    m = read_one("\"extensions\": {\"KHR_materials_volume\": {\"thicknessFactor\": 1,"
                 "\"thicknessTexture\": {\"index\": 1}, \"attenuationDistance\": 1e300}}",
                 &s);
    assert_true(m->thickness == 1 && m->attenuation_distance == 0); /* as good as infinite */
    assert_false(room_warned("thicknessTexture"));                  /* opaque: it says nothing */
    scene_unmap(&s);
}

TEST(any_two_sets_of_texture_coordinates_are_read)
{
    struct scene s;
    const char *third = "\"normalTexture\": {\"index\": 0}, \"pbrMetallicRoughness\": "
                        "{\"baseColorTexture\": {\"index\": 0, \"texCoord\": 3}}";
    const struct scene_material *m =
        read_with("\"POSITION\": 0, \"NORMAL\": 1, \"TEXCOORD_3\": 2", third, &s);
    assert_int_equal(m->base_color_texture.uv_set, 0); /* its first */
    assert_int_equal(m->normal_texture.uv_set, 1);
    assert_int_not_equal(s.meshes[0].first_uv[0], SCENE_NONE);
    assert_int_equal(s.meshes[0].first_uv[1], SCENE_NONE);
    assert_memory_equal(s.uvs, triangle.uvs, sizeof triangle.uvs);
    scene_unmap(&s);
    m = read_one(
        "\"normalTexture\": {\"index\": 0, \"texCoord\": 5}, \"emissiveTexture\": {\"index\": "
        "0, \"texCoord\": 1}, \"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0}}",
        &s);
    assert_true(m->base_color_texture.uv_set == 0 && m->normal_texture.uv_set == 1);
    assert_int_equal(m->emission_texture.texture, SCENE_NONE);
    assert_true(room_warned("more than two sets"));
    scene_unmap(&s);
}

TEST(one_side_is_the_default)
{
    struct scene s;
    assert_int_equal(read_one("\"name\": \"a\"", &s)->flags, MATERIAL_CULLED);
    scene_unmap(&s);
    assert_int_equal(read_one("\"doubleSided\": true", &s)->flags, MATERIAL_DOUBLE_SIDED);
    scene_unmap(&s);
}

TEST(anisotropy_brings_tangents)
{
    struct scene s;
    const char *turned = "\"extensions\": {\"KHR_materials_anisotropy\": {\"anisotropyStrength\": "
                         "0.5, \"anisotropyRotation\": 7, \"anisotropyTexture\": {\"index\": 1}}}";
    const struct scene_material *m = read_one(turned, &s);
    assert_true(m->anisotropy == 0.5f);
    assert_true(fabs((double)m->anisotropy_rad - (7 - 6.283185307179586)) < 1e-6);
    assert_int_equal(s.images[s.textures[m->anisotropy_texture.texture].image].flags, 0);
    assert_true(s.meshes[0].flags & MESH_HAS_TANGENTS); /* made from UVs */
    assert_true(s.tangents[0] == 1.0f);
    scene_unmap(&s);
    m = read_with(WITH_TANGENTS, turned, &s);
    assert_true(s.meshes[0].flags & MESH_HAS_TANGENTS); /* those of the file */
    assert_true(s.tangents[1] == 1.0f);
    scene_unmap(&s);
    m = read_with("\"POSITION\": 0, \"NORMAL\": 1", turned, &s);
    assert_false(s.meshes[0].flags & MESH_HAS_TANGENTS);
    assert_true(room_warned("the direction is arbitrary"));
    scene_unmap(&s);
    m = read_with(WITH_TANGENTS, "", &s);
    assert_false(s.meshes[0].flags & MESH_HAS_TANGENTS); /* needless */
    scene_unmap(&s);
}

TEST(blends_are_read)
{
    struct scene s;
    const struct scene_material *m = read_one("\"alphaMode\": \"BLEND\", \"pbrMetallicRoughness\": "
                                              "{\"baseColorFactor\": [1, 1, 1, 0.25]}",
                                              &s);
    assert_true(m->alpha_mode == ALPHA_BLEND && m->base_color[3] == 0.25f);
    assert_int_equal(room_warnings.count, 0);
    scene_unmap(&s);
}

#define EXTRAS(members) "\"extras\": {\"shearwater\": {" members "}}"
#define GREY            "\"pbrMetallicRoughness\": {\"baseColorFactor\": [0.5, 0.5, 0.5, 0.25]}, "

TEST(extras_choose_models)
{
    struct scene s;
    const struct scene_material *m = read_one(
        GREY EXTRAS("\"model\": \"phong\", \"exponent\": 50, \"specular\": [0.1, 0.2, 0.5]"), &s);
    assert_true(m->model == MODEL_PHONG && m->exponent_u == 50 && m->model_specular[1] == 0.2f);
    assert_true(m->base_color[0] == 0.5f && m->base_color[3] == 0.25f);
    scene_unmap(&s);
    m = read_one(EXTRAS("\"model\": \"blinn_phong\", \"exponent\": 9, \"specular\": [1, 0, 0]"),
                 &s);
    assert_true(m->model == MODEL_BLINN_PHONG && m->exponent_u == 9);
    assert_true(m->base_color[0] == 0.5f && m->model_specular[0] == 0.5f); /* 2 made 1 */
    assert_true(room_warned("sum up to more than 1"));
    scene_unmap(&s);
    m = read_one(GREY EXTRAS("\"model\": \"ashikhmin_shirley\", \"exponent_u\": 9, "
                             "\"exponent_v\": 90, \"specular\": [0.5, 0.5, 0.5]"),
                 &s);
    assert_true(m->model == MODEL_ASHIKHMIN_SHIRLEY && m->exponent_u == 9 && m->exponent_v == 90);
    assert_int_equal(s.count[SCENE_TANGENTS], s.count[SCENE_POSITIONS]);
    scene_unmap(&s);
    m = read_one(GREY EXTRAS("\"model\": \"ashikhmin_shirley\", \"exponent\": 9, "
                             "\"specular\": [0.5, 0.5, 0.5]"),
                 &s);
    assert_true(m->exponent_u == 9 && m->exponent_v == 9);
    assert_int_equal(s.count[SCENE_TANGENTS], 0);
    scene_unmap(&s);
    m = read_one(GREY EXTRAS("\"model\": \"ward\", \"alpha_u\": 0.5, \"alpha_v\": 0.125, "
                             "\"specular\": [0.5, 0.5, 0.5]"),
                 &s);
    assert_true(m->model == MODEL_WARD && m->alpha_u == 0.5f && m->alpha_v == 0.125f);
    scene_unmap(&s);
    m = read_one(EXTRAS("\"model\": \"kelemen\", \"alpha\": 0.5, \"specular\": [1, 0.5, 0]"), &s);
    assert_true(m->model == MODEL_KELEMEN && m->alpha_u == 0.5f && m->alpha_v == 0.5f);
    assert_true(m->base_color[0] == 1 && m->model_specular[0] == 1);
    scene_unmap(&s);
    m = read_one(GREY EXTRAS("\"model\": \"ward\", \"alpha\": 0.5, \"specular\": [0, 0, 0]"), &s);
    assert_true(m->alpha_u == 0.5f && m->alpha_v == 0.5f);
    scene_unmap(&s);
}

TEST(extras_make_metals_and_matt_ones)
{
    struct scene s;
    const struct scene_material *m =
        read_one(GREY EXTRAS("\"model\": \"beckmann\", \"alpha\": 0.25, \"eta\": [0.2, 1, 1.5], "
                             "\"k\": [4, 2, 0]"),
                 &s);
    assert_true(m->model == MODEL_BECKMANN && m->alpha_u == 0.25f);
    assert_true(m->eta[0] == 0.2f && m->k[1] == 2 && m->base_color[0] == 0);
    assert_true(m->base_color[3] == 0.25f && m->model_specular[2] == 1);
    scene_unmap(&s);
    m = read_one(GREY EXTRAS("\"model\": \"beckmann\", \"alpha\": 0.25, \"eta\": [1, 1, 1], "
                             "\"k\": [4, 2, 0], \"specular\": [0.3, 0.2, 0.1]"),
                 &s);
    assert_true(m->eta[0] == 1 && m->model_specular[2] == 0.1f && m->base_color[0] == 0);
    scene_unmap(&s);
    m = read_one(
        GREY EXTRAS("\"model\": \"beckmann\", \"alpha\": 0.5, \"specular\": [0.5, 0.25, 0]"), &s);
    assert_true(m->eta[0] == 0 && m->base_color[0] == 0.5f && m->model_specular[1] == 0.25f);
    scene_unmap(&s);
    m = read_one(GREY EXTRAS("\"model\": \"mirror\""), &s);
    assert_true(m->model == MODEL_MIRROR && m->model_specular[0] == 1 && m->base_color[0] == 0);
    scene_unmap(&s);
    m = read_one(GREY EXTRAS("\"model\": \"lambert\""), &s);
    assert_true(m->model == MODEL_GLTF && m->specular == 0 && m->metallic == 0);
    assert_true(m->base_color[0] == 0.5f);
    scene_unmap(&s);
    read_one("\"extras\": 7", &s); /* somebody else's */
    scene_unmap(&s);
    read_one("\"extras\": {\"other\": {\"model\": 3}}", &s);
    scene_unmap(&s);
}

TEST(names_what_it_refuses)
{
#define OURS "materials[0].extras.shearwater"
#define EXT  "materials[0].extensions."
    static const struct {
        const char *material;
        int code;
        const char *pointer;
    } rows[] = {
        {"\"extensions\": {\"KHR_materials_specular\": {\"specularColorFactor\": [-1, 0, 0]}}",
         ERR_RANGE, EXT "KHR_materials_specular.specularColorFactor"},
        {"\"extensions\": {\"KHR_materials_specular\": {\"specularTexture\": {\"index\": 9}}}",
         ERR_RANGE, EXT "KHR_materials_specular.specularTexture.index"},
        {"\"extensions\": {\"KHR_materials_ior\": {\"ior\": 0.5}}", ERR_RANGE,
         EXT "KHR_materials_ior"},
        {"\"extensions\": {\"KHR_materials_transmission\": {\"transmissionFactor\": 1.5}}",
         ERR_RANGE, EXT "KHR_materials_transmission.transmissionFactor"},
        {"\"extensions\": {\"KHR_materials_volume\": {\"thicknessFactor\": -1}}", ERR_RANGE,
         EXT "KHR_materials_volume.thicknessFactor"},
        {"\"extensions\": {\"KHR_materials_volume\": {\"thicknessTexture\": {\"index\": 7}}}",
         ERR_RANGE, EXT "KHR_materials_volume.thicknessTexture.index"},
        {"\"extensions\": {\"KHR_materials_volume\": {\"attenuationDistance\": 0}}", ERR_RANGE,
         EXT "KHR_materials_volume"},
        {"\"extensions\": {\"KHR_materials_volume\": {\"attenuationColor\": [1, 1, 2]}}", ERR_RANGE,
         EXT "KHR_materials_volume.attenuationColor"},
        {"\"extensions\": {\"KHR_materials_clearcoat\": {\"clearcoatNormalTexture\": {\"index\": "
         "0, "
         "\"scale\": \"NaN\"}}}",
         ERR_TYPE, EXT "KHR_materials_clearcoat.clearcoatNormalTexture.scale"},
        {"\"extensions\": {\"KHR_materials_sheen\": {\"sheenColorFactor\": [0, 0, 1.5]}}",
         ERR_RANGE, EXT "KHR_materials_sheen.sheenColorFactor"},
        {"\"extensions\": {\"KHR_materials_sheen\": {\"sheenRoughnessFactor\": \"NaN\"}}", ERR_TYPE,
         EXT "KHR_materials_sheen.sheenRoughnessFactor"},
        {"\"extensions\": {\"KHR_materials_diffuse_transmission\": "
         "{\"diffuseTransmissionFactor\": \"NaN\"}}",
         ERR_TYPE, EXT "KHR_materials_diffuse_transmission.diffuseTransmissionFactor"},
        {"\"extensions\": {\"KHR_materials_diffuse_transmission\": "
         "{\"diffuseTransmissionColorFactor\": [0, 2, 0]}}",
         ERR_RANGE, EXT "KHR_materials_diffuse_transmission.diffuseTransmissionColorFactor"},
        {"\"extensions\": {\"KHR_materials_iridescence\": {\"iridescenceIor\": 0.5}}", ERR_RANGE,
         EXT "KHR_materials_iridescence.iridescenceIor"},
        {"\"extensions\": {\"KHR_materials_iridescence\": {\"iridescenceThicknessMaximum\": -1}}",
         ERR_RANGE, EXT "KHR_materials_iridescence.iridescenceThicknessMaximum"},
        {"\"extensions\": {\"KHR_materials_dispersion\": {\"dispersion\": -1}}", ERR_RANGE,
         EXT "KHR_materials_dispersion.dispersion"},
        {"\"extensions\": {\"KHR_materials_dispersion\": {\"dispersion\": \"NaN\"}}", ERR_TYPE,
         EXT "KHR_materials_dispersion.dispersion"},
        {"\"extensions\": {\"KHR_materials_anisotropy\": {\"anisotropyStrength\": \"a\"}}",
         ERR_TYPE, EXT "KHR_materials_anisotropy.anisotropyStrength"},
        {"\"extras\": {\"shearwater\": 7}", ERR_TYPE, "materials[0].extras.shearwater"},
        {EXTRAS(""), ERR_MISSING, OURS ".model"},
        {EXTRAS("\"model\": \"velvet\""), ERR_RANGE, OURS ".model"},
        {EXTRAS("\"model\": 3"), ERR_TYPE, OURS ".model"},
        {EXTRAS("\"model\": \"phong\", \"specular\": [0, 0, 0]"), ERR_MISSING, OURS ".exponent"},
        {EXTRAS("\"model\": \"phong\", \"exponent\": 5"), ERR_MISSING, OURS ".specular"},
        {EXTRAS("\"model\": \"phong\", \"exponent\": -5, \"specular\": [0, 0, 0]"), ERR_RANGE,
         OURS ".exponent"},
        {EXTRAS("\"model\": \"phong\", \"exponent\": 5, \"specular\": [0, 0]"), ERR_RANGE,
         OURS ".specular"},
        {EXTRAS("\"model\": \"phong\", \"exponents\": 5"), ERR_UNKNOWN_MEMBER, OURS ".exponents"},
        {EXTRAS("\"model\": \"mirror\", \"exponent\": 5"), ERR_UNKNOWN_MEMBER, OURS ".exponent"},
        {EXTRAS("\"model\": \"lambert\", \"specular\": [0, 0, 0]"), ERR_UNKNOWN_MEMBER,
         OURS ".specular"},
        {EXTRAS("\"model\": \"beckmann\", \"alpha\": 0.5"), ERR_MISSING, OURS},
        {EXTRAS("\"model\": \"beckmann\", \"alpha\": 0.5, \"eta\": [1, 1, 1]"), ERR_MISSING, OURS},
        {EXTRAS("\"model\": \"beckmann\", \"alpha\": 0.5, \"k\": [1, 1, 1], "
                "\"specular\": [1, 1, 1]"),
         ERR_MISSING, OURS},
        {EXTRAS("\"model\": \"beckmann\", \"alpha\": 0.5, \"eta\": [0, 1, 1], \"k\": [1, 1, 1]"),
         ERR_RANGE, OURS ".eta"},
        {EXTRAS("\"model\": \"ashikhmin_shirley\", \"exponent_u\": 4, \"specular\": [1, 1, 1]"),
         ERR_MISSING, OURS},
        {EXTRAS("\"model\": \"ashikhmin_shirley\", \"exponent_u\": 4, \"exponent_v\": 4, "
                "\"exponent\": 4, \"specular\": [1, 1, 1]"),
         ERR_MISMATCH, OURS},
        {EXTRAS("\"model\": \"ward\", \"specular\": [1, 1, 1]"), ERR_MISSING, OURS},
        {EXTRAS("\"model\": \"ward\", \"alpha\": 0.1, \"alpha_u\": 0.1, \"specular\": [1, 1, 1]"),
         ERR_MISSING, OURS},
        {EXTRAS("\"model\": \"ward\", \"alpha\": 1.5, \"specular\": [1, 1, 1]"), ERR_RANGE,
         OURS ".alpha"},
        {EXTRAS("\"model\": \"beckmann\", \"alpha_u\": 0.1, \"alpha_v\": \"NaN\", "
                "\"specular\": [1, 1, 1]"),
         ERR_TYPE, OURS ".alpha_v"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        room_refuses("a.gltf", document(WITH_UVS, rows[i].material), rows[i].code, rows[i].pointer);
}
