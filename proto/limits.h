#pragma once
/* Every cap in one place. A number from outside is checked against these before memory is touched
 * for it. Each line says what is capped, its unit, and why the cap stands where it does. */

/* Image and sampling. */
#define LIMIT_IMAGE_SIDE_PX         16384     /* px; 16K stills, and tile indexes fit 32 bits */
#define LIMIT_OIDN_PIXELS           33554432  /* px; of filter.residual oidn: 1.6 GB for it */
#define LIMIT_IMAGE_PIXELS          134217728 /* px; 128 Mpx: output planes stay addressable */
#define LIMIT_SPP                   65536     /* samples per pixel of any kind; l is at most 256 */
#define LIMIT_COMPOSITE_SPP         16384     /* paths of each of three views: LIMIT_PASSES holds */
#define LIMIT_STRATA_PER_AXIS       256       /* l, so that l*l is LIMIT_SPP */
#define LIMIT_PLANE_STRATA_PER_AXIS 16        /* l where samples travel per stratum: 256 a pixel */
#define LIMIT_TILE_SIDE_MIN_PX      8         /* px; below this a tile costs more than it traces */
#define LIMIT_TILE_SIDE_PX          256       /* px; bounds a worker's memory and a result frame */
#define LIMIT_SUB_SAMPLES           3         /* anti-aliasing rays a pixel beside its centre */
#define LIMIT_LIGHTS                64        /* lights of a frame; each has planes of its own */
#define LIMIT_INDIRECT_BOUNCES      64        /* bounces after the first; beyond, nothing is left */
#define LIMIT_TEMPORAL_FRAMES       2         /* on each side, whose samples a frame uses */
#define LIMIT_PASS_SPP              64        /* samples a pixel that one lease asks for: seconds */
#define LIMIT_PASS_LENS_SAMPLES     256       /* the same through a lens, all of which are in one */
#define LIMIT_PASSES                1026      /* passes of a frame: those of LIMIT_SPP (plan.h) */
#define LIMIT_LENS_BLADES           32        /* sides of an aperture; more is a circle */
#define LIMIT_EXPOSURE_EV           32     /* stops: 2^32 covers every radiance of a half float */
#define LIMIT_FILTER_MU             100    /* factor of filter widths; beyond, all are capped */
#define LIMIT_FRAMES                100000 /* frames of a job */
#define LIMIT_FRAME_RUNS            64     /* runs of numbers, such as 20-40x2, of a job */
#define LIMIT_TIME_S                1e9    /* seconds; of a scene, both ways from 0 */
#define LIMIT_PRIORITY              100    /* |priority| */
#define LIMIT_COORDINATE            1e15f  /* |scene unit|; Embree aborts on 1e18 */
#define LIMIT_RADIANCE              1e12f  /* radiance, intensity or irradiance of a light */

/* Memory of a coordinator. */
#define LIMIT_TARGET_BYTES 8589934592ULL  /* bytes of samples that a frame with rounds keeps */
#define LIMIT_WINDOW_BYTES 12884901888ULL /* bytes of the frames of one window, all together */
#define LIMIT_LENS_BYTES   4294967296ULL  /* bytes of lens samples of a frame, all together */
#define LIMIT_PATCH_BYTES  268435456ULL   /* bytes of samples that a thread works on at once */

/* Documents. */
#define LIMIT_JOB_BYTES             1048576 /* bytes of a job document; jansson needs 13 times that */
#define LIMIT_CHANGE_BYTES          65536   /* bytes of a document that changes a job or a worker */
#define LIMIT_WAITING_MOVES         1024    /* of a live job, that wait for their scene */
#define LIMIT_WAITING_MOVES_BYTES   262144 /* of these documents together */
#define LIMIT_JSON_VALUES           32768 /* values of a document; a million take a tenth of a second */
#define LIMIT_JSON_DEPTH            64   /* nesting; jansson's own cap is 2048 */
#define LIMIT_JOB_ID_BYTES          64   /* bytes of a job's id, with its end */
#define LIMIT_NAME_BYTES            256  /* bytes of any name, with its end */
#define LIMIT_JOB_NAME              200  /* characters of a job's name */
#define LIMIT_JOB_COMMENT           4000 /* characters of a job's comment */
#define LIMIT_WEBHOOK_URL_BYTES     1024 /* bytes of the address that is told of a job's end */
#define LIMIT_JOB_LABELS            16   /* labels of a job */
#define LIMIT_JOB_LABEL             64   /* characters of a label */
#define LIMIT_POINTER_BYTES         256  /* bytes of a JSON pointer in a fault */
#define LIMIT_DETAIL_BYTES          512  /* bytes of a fault's sentence */
#define LIMIT_COMPOSITE_NAMES       64   /* names of catchers, and of holdouts */
#define LIMIT_MOVES                 32   /* nodes of a scene that a job moves */
#define LIMIT_SCENE_FILES           4096 /* files beside a scene's main file */
#define LIMIT_PATH_BYTES            512  /* bytes of a relative path inside a scene */
#define LIMIT_WARNINGS              64   /* warnings kept for a scene or a job */
#define LIMIT_IDEMPOTENCY_KEY_BYTES 128  /* bytes of an Idempotency-Key header */
#define LIMIT_LOG_LINES             200  /* lines of a job's log */
#define LIMIT_LIST_TEXT_BYTES       128  /* bytes that a listing may be searched for */
#define LIMIT_CAMERAS_LISTED        64   /* cameras that a plan names */

/* Assets and scene blobs. */
#define LIMIT_ASSET_BYTES         2147483648ULL /* bytes of an uploaded file */
#define LIMIT_SCENE_JSON_BYTES    134217728 /* bytes of a glTF's JSON; jansson needs 13 times that */
#define LIMIT_BLOB_BYTES          8589934592ULL /* bytes of a scene blob */
#define LIMIT_BLOB_PART_BYTES     1048576 /* bytes of a blob in one message; a link stays lively */
#define LIMIT_VERTICES            200000000u /* vertices of a scene */
#define LIMIT_TRIANGLES           200000000u /* triangles of a scene before instancing */
#define LIMIT_MESHES              1000000u   /* meshes (glTF primitives) */
#define LIMIT_INSTANCES           4000000u   /* placed meshes */
#define LIMIT_MATERIALS           65536u     /* materials */
#define LIMIT_IMAGES              4096u      /* decoded images */
#define LIMIT_TEXTURE_SIDE_PX     16384u     /* px of a decoded image's side */
#define LIMIT_CAMERAS             4096u      /* cameras */
#define LIMIT_ENVIRONMENT_SIDE_PX 16384u     /* px of an environment map's width */
#define LIMIT_ENVIRONMENT_PIXELS  33554432u  /* px; 8192 x 4096: 400 MB as floats */
#define LIMIT_NODE_DEPTH          256        /* nesting of a scene graph */
#define LIMIT_POSES               65536u     /* poses of a sequence; each frame is sought in them */
#define LIMIT_FUSION_BLOCKS       32768u     /* blocks of 512 voxels of 16 bytes: 270 MB */
#define LIMIT_FUSION_FRAMES       64u        /* frames that one model is made of, */
#define LIMIT_FUSION_PIXELS       33554432u /* and their pixels together, but one frame's at least */
#define LIMIT_DEPTH_PIXELS        4194304u  /* px of a depth image: each becomes two triangles */

/* The wire. */
#define LIMIT_FRAME_BYTES   134217728u /* payload bytes of a wire frame */
#define LIMIT_HELLO_BYTES   4096u      /* payload bytes before a session is welcome */
#define LIMIT_TILES_IN_HAND 256        /* tiles that one worker may hold */
#define LIMIT_WORKERS       4096       /* sessions of a coordinator */
#define LIMIT_THREADS       1024       /* tracing threads of a worker */

/* HTTP. */
#define LIMIT_HTTP_CONNECTIONS 2048   /* open connections; each may hold 24 KB of head */
#define LIMIT_HTTP_URL_BYTES   4096   /* bytes of a request target */
#define LIMIT_LIST_ROWS        100    /* rows of one page of a listing */
#define LIMIT_EVENT_RING       256    /* events kept for replay, per job */
#define LIMIT_STUCK_MS         30000  /* ms that a reader of a stream may take nothing */
#define LIMIT_JOBS_WAITING     100000 /* jobs not yet finished */
#define LIMIT_REQUEST_MS       30000  /* ms that a request without a body may take to arrive */
#define LIMIT_UPLOAD_MS        600000 /* ms that an upload may take to arrive */
#define LIMIT_ANSWER_MS        20000  /* ms that the store may take to answer a request */
#define LIMIT_UPLOAD_PACE                                                                          \
    32768 /* bytes a second that an upload must bring after LIMIT_REQUEST_MS */

/* Blocks of pictures in the form in which feeds send them, in bytes: those shared by all feeds of
 * pictures in work, those kept of a picture that has ended for feeds that are behind, and those of
 * all pictures together. */
#define LIMIT_SHARED_PIXELS_BYTES (256u << 20)
#define LIMIT_KEPT_PIXELS_BYTES   (256u << 20)
#define LIMIT_PIXELS_BYTES        (512u << 20)

/* Access control. */
#define LIMIT_TOKENS            4096    /* tokens of a coordinator */
#define LIMIT_TOKENS_FILE_BYTES 1048576 /* bytes of the file that they come from */

/* Tiles on disk, until their frame has its files. */
#define LIMIT_SPOOL_BYTES       17179869184ULL /* bytes of all frames; beyond, tiles are not kept */
#define LIMIT_SPOOL_SPARE_BYTES 134217728ULL   /* of the disk that are left to jobs and files */
#define LIMIT_SPOOL_QUEUE_BYTES 67108864u      /* bytes of memory that wait for the disk */
#define LIMIT_SPOOL_RECORDS     1048576u       /* of a frame; 40 bytes of memory each to take up */

/* The importer's fence. */
#define LIMIT_IMPORT_MS           120000        /* ms of wall time */
#define LIMIT_IMPORT_CPU_S        120           /* s of CPU time */
#define LIMIT_IMPORT_MEMORY_BYTES 8589934592ULL /* bytes of address space */
