// count.cl - how often the steps of traversals are taken, for tests/peers/limit.py, which builds with -DCOUNTING=1, 2, ...:
// four counts from 4 * (COUNTING - 1) on then take the place of a pixel's rays. Else nothing is counted.
#ifndef COUNTING
#define COUNTING 0
#endif
#ifndef TRAVERSALS // 2: every traversal twice, so that the difference is its time
#define TRAVERSALS 1
#endif
#ifndef SEND_ALL // 1: pixels whose rays can meet nothing send them all the same
#define SEND_ALL 0
#endif

#define COUNT_LONE 0     // one ray's ways
#define COUNT_NODES 1    // whose children one ray asks
#define COUNT_CHILDREN 2 // that it meets
#define COUNT_BEAMS 4    // many rays' ways
#define COUNT_BOXES 5    // nodes whose children a beam asks
#define COUNT_TESTS 6    // children that all of its rays ask
#define COUNT_ERRANDS 7  // children that wait
// By kind, and whether they go together: blocks or entries tried, those where something is found, blocks that a beam asks.
#define COUNT_TRIED(kind, together) (8 + (kind)*8 + ((together) ? 0 : 4))
#define COUNT_FOUND(kind, together) (COUNT_TRIED(kind, together) + 1)
#define COUNT_BLOCKS(kind) (COUNT_TRIED(kind, false) + 2)
#define COUNTS 72

#if COUNTING
#define COUNT(s, what, times) ((s)->counts[what] += (times))
#define NO_COUNTS                                                                                                      \
    , (private uint[COUNTS]) {                                                                                         \
        0                                                                                                              \
    } // a scene's last member
#else
#define COUNT(s, what, times) ((void)0)
#define NO_COUNTS
#endif
