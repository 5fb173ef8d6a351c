!> Orderings of symmetric sparse matrices: near to the diagonal, or with little fill.
module taut_linalg_ordering
   implicit none (type, external)
   private
   public :: reverse_cuthill_mckee, minimum_degree, bandwidth

   !> The neighbors of a vertex.
   type :: neighbors_t
      integer, allocatable :: of(:)
   end type neighbors_t

contains

   !> The ordering of Cuthill and McKee, reversed, from an end of the graph.
   !!
   !! Source: A. George, J.W.H. Liu, Computer Solution of Large Sparse Positive Definite Systems, Prentice-Hall 1981, ch. 4.
   subroutine reverse_cuthill_mckee(first, neighbor, order)
      !> First neighbor of each vertex, and the number of neighbors in all plus one at the end: (n + 1).
      integer, intent(in) :: first(:)
      !> The neighbors of each vertex.
      integer, intent(in) :: neighbor(:)
      !> The vertices in their new order: (n).
      integer, intent(out) :: order(:)
      integer :: depth, deeper, found, i, n, root, start, last
      logical :: placed(size(order))

      n = size(order)
      placed = .false.
      found = 0
      do start = 1, n
         if (placed(start)) cycle
         ! An end of this part of the graph: the farthest vertex from the farthest vertex ...
         root = start
         depth = -1
         do i = 1, 10
            call search(root, 0, last, deeper)
            if (deeper <= depth) exit
            depth = deeper
            root = last
         end do
         call search(root, 1, last, deeper)
         found = found + deeper
      end do
      order = order(n:1:-1)

   contains

      !> Breadth first from a vertex, into `order` behind what is there; neighbors with fewer neighbors come first. Without
      !! `keep`, gives the number of levels and the vertex of least degree in the last one; with it, the vertices found.
      subroutine search(from, keep, last_one, depth_or_number)
         integer, intent(in) :: from, keep
         integer, intent(out) :: last_one, depth_or_number
         integer :: head, j, k, level_end, levels, tail, v, begin

         order(found + 1) = from
         placed(from) = .true.
         head = found + 1
         tail = found + 1
         levels = 0
         begin = head
         do while (head <= tail)
            begin = head
            level_end = tail
            levels = levels + 1
            do while (head <= level_end)
               v = tail
               do k = first(order(head)), first(order(head) + 1) - 1
                  if (placed(neighbor(k))) cycle
                  placed(neighbor(k)) = .true.
                  ! Sorted by insertion among the neighbors of this vertex.
                  j = tail
                  tail = tail + 1
                  do while (j > v)
                     if (degree(order(j)) <= degree(neighbor(k))) exit
                     order(j + 1) = order(j)
                     j = j - 1
                  end do
                  order(j + 1) = neighbor(k)
               end do
               head = head + 1
            end do
         end do
         last_one = order(begin)
         do j = begin + 1, tail
            if (degree(order(j)) < degree(last_one)) last_one = order(j)
         end do
         depth_or_number = tail - found
         if (keep == 1) return
         depth_or_number = levels
         do j = found + 1, tail
            placed(order(j)) = .false.
         end do
      end subroutine search

      pure integer function degree(v)
         integer, intent(in) :: v

         degree = first(v + 1) - first(v)
      end function degree

   end subroutine reverse_cuthill_mckee

   !> Eliminates next what has the fewest neighbors: a tree is not filled in at all.
   subroutine minimum_degree(first, neighbor, order)
      !> First neighbor of each vertex, and the number of neighbors in all plus one at the end: (n + 1).
      integer, intent(in) :: first(:)
      !> The neighbors of each vertex.
      integer, intent(in) :: neighbor(:)
      !> The vertices in their new order: (n).
      integer, intent(out) :: order(:)
      type(neighbors_t) :: graph(size(order))
      integer, dimension(size(order)) :: after, before, degree, mark, merged
      integer :: head(0:size(order)), i, j, k, least, m, n, u, v

      n = size(order)
      head = 0
      mark = 0
      do v = 1, n
         graph(v)%of = neighbor(first(v):first(v + 1) - 1)
         degree(v) = size(graph(v)%of)
      end do
      do v = n, 1, -1
         call put(v)
      end do
      least = 0
      do i = 1, n
         do while (head(least) == 0)
            least = least + 1
         end do
         v = head(least)
         call take(v)
         order(i) = v
         ! Its neighbors become neighbors of each other.
         do j = 1, size(graph(v)%of)
            u = graph(v)%of(j)
            call take(u)
            m = 0
            mark(u) = u
            mark(v) = u
            do k = 1, size(graph(u)%of)
               call add(graph(u)%of(k))
            end do
            do k = 1, size(graph(v)%of)
               call add(graph(v)%of(k))
            end do
            mark(merged(:m)) = 0
            mark(u) = 0
            mark(v) = 0
            graph(u)%of = merged(:m)
            degree(u) = m
            call put(u)
            least = min(least, m)
         end do
         deallocate (graph(v)%of)
      end do

   contains

      subroutine add(w)
         integer, intent(in) :: w

         if (mark(w) == u) return
         mark(w) = u
         m = m + 1
         merged(m) = w
      end subroutine add

      !> Into the list of its degree.
      subroutine put(w)
         integer, intent(in) :: w

         before(w) = 0
         after(w) = head(degree(w))
         if (after(w) > 0) before(after(w)) = w
         head(degree(w)) = w
      end subroutine put

      !> Out of it.
      subroutine take(w)
         integer, intent(in) :: w

         if (before(w) > 0) then
            after(before(w)) = after(w)
         else
            head(degree(w)) = after(w)
         end if
         if (after(w) > 0) before(after(w)) = before(w)
      end subroutine take

   end subroutine minimum_degree

   !> How far neighbors are apart in an ordering.
   pure function bandwidth(first, neighbor, order) result(width)
      !> First neighbor of each vertex, and the number of neighbors in all plus one at the end: (n + 1).
      integer, intent(in) :: first(:)
      !> The neighbors of each vertex.
      integer, intent(in) :: neighbor(:)
      !> The vertices in their order: (n).
      integer, intent(in) :: order(:)
      !> Largest distance.
      integer :: width
      integer :: i, k, place(size(order))

      do i = 1, size(order)
         place(order(i)) = i
      end do
      width = 0
      do i = 1, size(order)
         do k = first(i), first(i + 1) - 1
            width = max(width, abs(place(i) - place(neighbor(k))))
         end do
      end do
   end function bandwidth

end module taut_linalg_ordering
