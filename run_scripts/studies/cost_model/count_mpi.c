/* Counts what this process asks of MPI, whoever asks: parisph, PETSc or hypre. To be loaded before MPI (LD_PRELOAD).

   Built and used by messages.py. Sends to itself and calls on communicators of one rank do not count. */
#if __has_include(<mpi.h>)
#include <mpi.h>
#else    /* without headers, as of an installed Open MPI: its handles are pointers */
typedef void *MPI_Comm, *MPI_Datatype, *MPI_Op, *MPI_Request, *MPI_Group;
#define MPI_PROC_NULL (-2)
#endif

#define MOST 65536

static long counts[3];    /* sends, their bytes, collectives */
static struct { MPI_Request request; long bytes; int used; } kept[MOST];    /* persistent sends */

int PMPI_Type_size(MPI_Datatype type, int *size);
int PMPI_Comm_rank(MPI_Comm comm, int *rank);
int PMPI_Comm_size(MPI_Comm comm, int *size);

void mpi_counted(long *found)
{
    for (int k = 0; k < 3; k++) found[k] = counts[k];
}

static long bytes_of(int n, MPI_Datatype type)
{
    int size = 0;
    PMPI_Type_size(type, &size);
    return (long)n * size;
}

static int goes_out(int to, MPI_Comm comm)
{
    int rank = -1;
    PMPI_Comm_rank(comm, &rank);
    return to != MPI_PROC_NULL && to != rank;
}

static void sent(int n, MPI_Datatype type, int to, MPI_Comm comm)
{
    if (goes_out(to, comm)) { counts[0]++; counts[1] += bytes_of(n, type); }
}

static void together(MPI_Comm comm)
{
    int size = 1;
    PMPI_Comm_size(comm, &size);
    counts[2] += size > 1;
}

static void keep(MPI_Request request, long bytes)
{
    for (int k = 0; k < MOST; k++)
        if (!kept[k].used) { kept[k].request = request; kept[k].bytes = bytes; kept[k].used = 1; return; }
}

static void started(MPI_Request request)
{
    for (int k = 0; k < MOST; k++)
        if (kept[k].used && kept[k].request == request) { counts[0]++; counts[1] += kept[k].bytes; return; }
}

static void forget(MPI_Request request)
{
    for (int k = 0; k < MOST; k++)
        if (kept[k].used && kept[k].request == request) { kept[k].used = 0; return; }
}

/* A function of MPI that does something before it calls the library. */
#define BEFORE(does, name, takes, gives) \
    int PMPI_##name takes; \
    int MPI_##name takes { does; return PMPI_##name gives; }
/* The same, after it. */
#define AFTER(does, name, takes, gives) \
    int PMPI_##name takes; \
    int MPI_##name takes { int code = PMPI_##name gives; does; return code; }

#define DATA const void *data, int n, MPI_Datatype type

BEFORE(sent(n, type, to, comm), Send, (DATA, int to, int tag, MPI_Comm comm), (data, n, type, to, tag, comm))
BEFORE(sent(n, type, to, comm), Ssend, (DATA, int to, int tag, MPI_Comm comm), (data, n, type, to, tag, comm))
BEFORE(sent(n, type, to, comm), Rsend, (DATA, int to, int tag, MPI_Comm comm), (data, n, type, to, tag, comm))
BEFORE(sent(n, type, to, comm), Isend, (DATA, int to, int tag, MPI_Comm comm, MPI_Request *request),
       (data, n, type, to, tag, comm, request))
BEFORE(sent(n, type, to, comm), Issend, (DATA, int to, int tag, MPI_Comm comm, MPI_Request *request),
       (data, n, type, to, tag, comm, request))
BEFORE(sent(n, type, to, comm), Irsend, (DATA, int to, int tag, MPI_Comm comm, MPI_Request *request),
       (data, n, type, to, tag, comm, request))
AFTER(if (goes_out(to, comm)) keep(*request, bytes_of(n, type)), Send_init,
      (DATA, int to, int tag, MPI_Comm comm, MPI_Request *request), (data, n, type, to, tag, comm, request))
BEFORE(started(*request), Start, (MPI_Request *request), (request))
BEFORE(for (int k = 0; k < n; k++) started(requests[k]), Startall, (int n, MPI_Request *requests), (n, requests))
BEFORE(forget(*request), Request_free, (MPI_Request *request), (request))

BEFORE(together(comm), Allreduce,
       (const void *a, void *b, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm),
       (a, b, n, t, op, comm))
BEFORE(together(comm), Reduce,
       (const void *a, void *b, int n, MPI_Datatype t, MPI_Op op, int root, MPI_Comm comm),
       (a, b, n, t, op, root, comm))
BEFORE(together(comm), Scan,
       (const void *a, void *b, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm),
       (a, b, n, t, op, comm))
BEFORE(together(comm), Exscan,
       (const void *a, void *b, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm),
       (a, b, n, t, op, comm))
BEFORE(together(comm), Iallreduce,
       (const void *a, void *b, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm, MPI_Request *r),
       (a, b, n, t, op, comm, r))
BEFORE(together(comm), Bcast, (void *a, int n, MPI_Datatype t, int root, MPI_Comm comm), (a, n, t, root, comm))
BEFORE(together(comm), Barrier, (MPI_Comm comm), (comm))
BEFORE(together(comm), Ibarrier, (MPI_Comm comm, MPI_Request *r), (comm, r))
BEFORE(together(comm), Comm_dup, (MPI_Comm comm, MPI_Comm *made), (comm, made))
BEFORE(together(comm), Comm_split, (MPI_Comm comm, int color, int key, MPI_Comm *made), (comm, color, key, made))
BEFORE(together(comm), Comm_create, (MPI_Comm comm, MPI_Group group, MPI_Comm *made), (comm, group, made))
BEFORE(together(comm), Alltoall,
       (const void *a, int m, MPI_Datatype s, void *b, int n, MPI_Datatype t, MPI_Comm comm),
       (a, m, s, b, n, t, comm))
BEFORE(together(comm), Allgather,
       (const void *a, int m, MPI_Datatype s, void *b, int n, MPI_Datatype t, MPI_Comm comm),
       (a, m, s, b, n, t, comm))
BEFORE(together(comm), Gather,
       (const void *a, int m, MPI_Datatype s, void *b, int n, MPI_Datatype t, int root, MPI_Comm comm),
       (a, m, s, b, n, t, root, comm))
BEFORE(together(comm), Scatter,
       (const void *a, int m, MPI_Datatype s, void *b, int n, MPI_Datatype t, int root, MPI_Comm comm),
       (a, m, s, b, n, t, root, comm))
BEFORE(together(comm), Allgatherv,
       (const void *a, int m, MPI_Datatype s, void *b, const int *n, const int *i, MPI_Datatype t, MPI_Comm comm),
       (a, m, s, b, n, i, t, comm))
BEFORE(together(comm), Gatherv,
       (const void *a, int m, MPI_Datatype s, void *b, const int *n, const int *i, MPI_Datatype t, int root,
        MPI_Comm comm),
       (a, m, s, b, n, i, t, root, comm))
BEFORE(together(comm), Alltoallv,
       (const void *a, const int *m, const int *i, MPI_Datatype s, void *b, const int *n, const int *j, MPI_Datatype t,
        MPI_Comm comm),
       (a, m, i, s, b, n, j, t, comm))
