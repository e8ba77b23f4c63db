#pragma once
/* How the pixels of an EXR file are compressed: image.exr_compression of a job document. */

enum exr_codec {
    EXR_CODEC_ZIP,  /* deflate, 16 rows at a time */
    EXR_CODEC_ZIPS, /* deflate, a row at a time: what compositors read fastest */
    EXR_CODEC_PIZ,  /* wavelets, 32 rows: smaller where there is grain */
    EXR_CODEC_DWAA, /* DCT, 32 rows, with loss: a fraction of the others */
    EXR_CODEC_NONE
};
